"""Where the camera is in the world, from joint angles and the feet that stand."""

from itertools import pairwise

import numpy as np
import pinocchio as pin

from w2c.errors import GeometryError
from w2c.geometry import Matrix, apply
from w2c.messages import Array, RobotDescription
from w2c.stance import Soles, Stance, both_feet
from w2c_perception.pose import CameraPose


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
        joints = [self._joint(joint.name) for joint in description.joints]
        self._indices = np.array([joint.idx_q for joint in joints])
        self._columns = np.array([joint.idx_v for joint in joints])
        self._left, self._right = (self._frame_id(name) for name in description.sole_frames)
        self._camera = self._frame_id(description.camera_frame)
        self._hands = tuple(self._frame_id(name) for name in description.hand_frames)
        self._arms = self._arm_chains()

    @property
    def joint_count(self) -> int:
        """Return how many angles a position has."""
        return len(self._indices)

    def soles(self, position: Array) -> Soles:
        """Return base_from_sole (4, 4), left and right.

        Args:
            position: (n,) joint angles in the order of the description [rad].

        Raises:
            GeometryError: another number of angles, or one that is not finite.
        """
        self._forward(position)
        return self._placement(self._left), self._placement(self._right)

    def camera_pose(self, position: Array, stance: Stance | None = None) -> CameraPose:
        """Return where the camera and the arms are.

        `world_from_camera = world_from_base @ base_from_camera`, the base by the feet that stand.

        Args:
            position: (n,) joint angles in the order of the description [rad].
            stance: the feet; None: both stand, and the world is midway between them.

        Raises:
            GeometryError: another number of angles, or one that is not finite.
        """
        soles = self.soles(position)
        stance = stance or both_feet(soles)
        world_from_base = stance.world_from_base(soles)
        camera = self._placement(self._camera)
        return CameraPose(
            world_from_camera=np.asarray(world_from_base @ camera),
            arms=self._bones(world_from_base),
            twists=self._twists(stance, world_from_base),
        )

    def _forward(self, position: Array) -> None:
        """Run the kinematics. Raises GeometryError."""
        if position.shape != self._indices.shape or not np.isfinite(position).all():
            raise GeometryError(
                f"joint angles of shape {position.shape}, expected finite {self._indices.shape}"
            )
        configuration = pin.neutral(self._model)
        configuration[self._indices] = position
        pin.computeJointJacobians(self._model, self._data, configuration)

    def _placement(self, frame: int) -> Matrix:
        """Return base_from_frame (4, 4), as a copy."""
        return np.array(pin.updateFramePlacement(self._model, self._data, frame).homogeneous)

    def _bones(self, world_from_base: Matrix) -> Array:
        """Return the bones of both arms (n, 2, 3): from joint to joint, and on to the hand [m]."""
        bones = []
        for chain, hand in zip(self._arms, self._hands, strict=True):
            tip = self._placement(hand)[:3, 3]
            ends = [*(self._data.oMi[joint].translation for joint in chain), tip]
            bones += list(pairwise(apply(world_from_base, np.array(ends))))
        return np.array(bones)

    def _twists(self, stance: Stance, world_from_base: Matrix) -> Array:
        """Return the camera's twists (n, 6) in the world: its own less those of what stands."""
        of_camera = self._spatial(self._camera)
        soles = (self._left, self._right)
        feet = [soles[foot] for foot in (0, 1) if stance.standing[foot]]
        of_feet = np.mean([self._spatial(frame) for frame in feet], axis=0)
        if len(feet) == 2:
            # Points midway between the soles move with the mean of both: their own, not the
            # twists', where the feet turn against each other.
            places = [self._placement(frame)[:3, 3] for frame in feet]
            middle = 0.5 * (places[0] + places[1])
            of_feet[:, :3] = np.mean(
                [
                    self._spatial(frame)[:, :3] + np.cross(self._spatial(frame)[:, 3:], place)
                    for frame, place in zip(feet, places, strict=True)
                ],
                axis=0,
            ) - np.cross(of_feet[:, 3:], middle)
        relative = of_camera - of_feet
        rotation, origin = world_from_base[:3, :3], world_from_base[:3, 3]
        angular = relative[:, 3:] @ rotation.T
        linear = relative[:, :3] @ rotation.T - np.cross(angular, origin)
        return np.hstack([linear, angular])

    def _spatial(self, frame: int) -> Array:
        """Return the twist (n, 6) of a link with each joint, at the base's origin, in the base."""
        twists = np.zeros((self.joint_count, 6))
        joint = self._model.frames[frame].parentJoint
        column_of = {int(column): row for row, column in enumerate(self._columns)}
        while joint > 0:
            column = int(self._model.joints[joint].idx_v)
            if column in column_of:
                twists[column_of[column]] = self._data.J[:, column]
            joint = self._model.parents[joint]
        return twists

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

    def _joint(self, name: str) -> "pin.JointModel":
        if not self._model.existJointName(name):
            raise GeometryError(
                f"the robot's URDF has no joint '{name}', which its description names"
            )
        row = self._model.joints[self._model.getJointId(name)]
        if row.nq != 1:
            raise GeometryError(f"joint '{name}' has {row.nq} coordinates, expected 1")
        return row

    def _frame_id(self, name: str) -> int:
        if not self._model.existFrame(name):
            raise GeometryError(
                f"the robot's URDF has no frame '{name}', which its description names"
            )
        return int(self._model.getFrameId(name))
