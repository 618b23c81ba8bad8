"""Where the camera is in the world, from joint angles alone."""

import numpy as np
import pinocchio as pin

from w2c.errors import GeometryError
from w2c.geometry import Matrix, base_from_midfeet, inverse
from w2c.messages import Array, RobotDescription


class CameraKinematics:
    """The robot's model, from its description. Not thread-safe: it holds Pinocchio's work space."""

    def __init__(self, description: RobotDescription) -> None:
        """Build the model.

        Raises:
            GeometryError: the description's model lacks a joint or a frame that it names.
        """
        try:
            self._model = pin.buildModelFromXML(description.urdf)
        except ValueError as error:
            raise GeometryError(f"the robot's URDF cannot be read: {error}") from error
        self._data = self._model.createData()
        self._indices = np.array([self._position_index(joint.name) for joint in description.joints])
        self._soles = tuple(self._frame_id(name) for name in description.sole_frames)
        self._camera = self._frame_id(description.camera_frame)

    @property
    def joint_count(self) -> int:
        """Return how many angles `world_from_camera` takes."""
        return len(self._indices)

    def world_from_camera(self, position: Array) -> Matrix:
        """Return the pose (4, 4) of the optical frame.

        The world is the frame midway between the soles, so that
        `world_from_camera = inverse(base_from_midfeet) @ base_from_camera`: no base estimate is
        needed while both feet stand.

        Args:
            position: (n,) joint angles in the order of the description [rad].

        Raises:
            GeometryError: another number of angles, or one that is not finite.
        """
        if position.shape != self._indices.shape or not np.isfinite(position).all():
            raise GeometryError(
                f"joint angles of shape {position.shape}, expected finite {self._indices.shape}"
            )
        configuration = pin.neutral(self._model)
        configuration[self._indices] = position
        pin.forwardKinematics(self._model, self._data, configuration)
        left, right, camera = (
            pin.updateFramePlacement(self._model, self._data, frame).homogeneous
            for frame in (*self._soles, self._camera)
        )
        return np.asarray(inverse(base_from_midfeet(left, right)) @ camera)

    def _position_index(self, joint: str) -> int:
        if not self._model.existJointName(joint):
            raise GeometryError(
                f"the robot's URDF has no joint '{joint}', which its description names"
            )
        row = self._model.joints[self._model.getJointId(joint)]
        if row.nq != 1:
            raise GeometryError(f"joint '{joint}' has {row.nq} coordinates, expected 1")
        return int(row.idx_q)

    def _frame_id(self, name: str) -> int:
        if not self._model.existFrame(name):
            raise GeometryError(
                f"the robot's URDF has no frame '{name}', which its description names"
            )
        return int(self._model.getFrameId(name))
