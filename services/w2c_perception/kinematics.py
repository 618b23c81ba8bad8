"""Where the camera is in the world, from joint angles alone."""

from itertools import pairwise

import numpy as np
import pinocchio as pin

from w2c.errors import GeometryError
from w2c.geometry import Matrix, apply, base_from_midfeet, inverse
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
        self._hands = tuple(self._frame_id(name) for name in description.hand_frames)
        self._arms = self._arm_chains()

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
        left, right, camera = self._placements((*self._soles, self._camera), position)
        return np.asarray(inverse(base_from_midfeet(left, right)) @ camera)

    def arms_in_world(self, position: Array) -> Array:
        """Return the bones of both arms (n, 2, 3): from joint to joint, and on to the hand [m].

        Args:
            position: (n,) joint angles in the order of the description [rad].

        Raises:
            GeometryError: another number of angles, or one that is not finite.
        """
        left, right, *hands = self._placements((*self._soles, *self._hands), position)
        world_from_base = inverse(base_from_midfeet(left, right))
        bones = []
        for chain, hand in zip(self._arms, hands, strict=True):
            ends = [*(self._data.oMi[joint].translation for joint in chain), hand[:3, 3]]
            in_world = apply(world_from_base, np.array(ends))  # (joints + 1, 3)
            bones += list(pairwise(in_world))
        return np.array(bones)

    def _placements(self, frames: tuple[int, ...], position: Array) -> list[Matrix]:
        """Return base_from_frame (4, 4) of each frame, as copies. Raises GeometryError."""
        if position.shape != self._indices.shape or not np.isfinite(position).all():
            raise GeometryError(
                f"joint angles of shape {position.shape}, expected finite {self._indices.shape}"
            )
        configuration = pin.neutral(self._model)
        configuration[self._indices] = position
        pin.forwardKinematics(self._model, self._data, configuration)
        return [
            np.array(pin.updateFramePlacement(self._model, self._data, frame).homogeneous)
            for frame in frames
        ]

    def _arm_chains(self) -> list[list[int]]:
        """Return the joints of each arm, shoulder first: those that only one hand depends on."""
        supports = []
        for hand in self._hands:
            joint, chain = self._model.frames[hand].parentJoint, []
            while joint > 0:
                chain.append(joint)
                joint = self._model.parents[joint]
            supports.append(chain[::-1])
        left, right = supports
        return [[j for j in left if j not in right], [j for j in right if j not in left]]

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
