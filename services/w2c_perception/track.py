"""One robot since it started: its joint angles, the feet that stand, and where its camera was."""

import numpy as np

from w2c.errors import GeometryError
from w2c.geometry import rotation_from_quaternion, transform
from w2c.messages import CameraFrame, ControllerStatus, RobotDescription, RobotState
from w2c.stance import Stance, StanceEstimator
from w2c_perception.buffer import StateBuffer, View
from w2c_perception.kinematics import CameraKinematics

MAX_APART_NS = 300_000_000
"""Colours and depth farther apart may show different things"""
VERTICAL_FORCE = 2
"""Of a sole's wrench: the force along its normal"""


class RobotTrack:
    """Follows the states of one robot, of one boot. Not thread-safe."""

    def __init__(self, description: RobotDescription, boot_id: str, history_s: float) -> None:
        """Begin.

        Args:
            description: of the robot.
            boot_id: of its process.
            history_s: how long states are remembered [s].

        Raises:
            GeometryError: the description contradicts itself.
        """
        self.boot_id = boot_id
        self._kinematics = CameraKinematics(description)
        self._camera_frame = description.camera_frame
        self._stances = StanceEstimator()
        self._states = StateBuffer(history_s)
        self._first_ns = self._last_ns = -1

    @property
    def age_ns(self) -> int:
        """Return for how long states have come [ns of robot time]."""
        return self._last_ns - self._first_ns

    @property
    def newest_ns(self) -> int:
        """Return the stamp of the newest state, -1 before the first."""
        return self._states.newest_ns

    @property
    def stance(self) -> Stance | None:
        """Return where the feet stand; None while no foot does."""
        return self._stances.stance

    @property
    def world(self) -> int:
        """Return the number of the present world, 0 before the first; a new one is elsewhere."""
        return 0 if self.stance is None else self.stance.world

    def add(self, state: RobotState) -> None:
        """Take a state.

        Raises:
            GeometryError: joint angles that are not finite, or of another robot.
        """
        count = self._kinematics.joint_count
        if state.position.shape != (count,) or not np.isfinite(state.position).all():
            raise GeometryError(
                f"state of {state.stamp_ns} ns: joint angles of shape {state.position.shape}, "
                f"expected {count} finite ones"
            )
        if state.stamp_ns < self._states.newest_ns:
            self._stances = StanceEstimator()
        stance = self._stances.update(
            state.stamp_ns,
            state.sole_wrenches[:, VERTICAL_FORCE],
            lambda: self._kinematics.soles(state.position),
        )
        if self._first_ns < 0 or state.stamp_ns < self._last_ns:
            self._first_ns = state.stamp_ns
        self._last_ns = state.stamp_ns
        self._states.add(state.stamp_ns, state.position, stance)

    def follow(self, status: ControllerStatus) -> bool:
        """Take the controller's world, where it is another one: it began before a step of the feet.

        States of before are forgotten then. Returns False where the controller, or this process,
        does not know yet where the feet are.

        Raises:
            GeometryError: poses that are none.
        """
        stance, soles = self._stances.stance, status.soles
        if soles is None or stance is None:
            return False
        if any(
            ours and not theirs
            for ours, theirs in zip(stance.standing, status.in_contact[:2], strict=True)
        ):
            return False  # a foot that comes down or is lifted: the next status knows better
        left, right = (transform(rotation_from_quaternion(row[3:]), row[:3]) for row in soles)
        self._stances.move((left, right))
        if self.world != stance.world:
            self._states.clear()
        return True

    def place(self, frame: CameraFrame) -> View:
        """Return a frame with where it was taken from.

        Raises:
            GeometryError: a frame that is not of this robot's camera, or whose numbers are none.
            RefusedError: no joint angles at its stamp, or no foot on the ground.
        """
        if frame.frame != self._camera_frame:
            raise GeometryError(
                f"picture of '{frame.frame}', this robot's camera is '{self._camera_frame}'; is "
                "the camera process that of another robot?"
            )
        fx, fy, cx, cy = frame.intrinsics
        if not (np.isfinite([fx, fy, cx, cy]).all() and fx > 0.0 and fy > 0.0):
            raise GeometryError(
                f"intrinsics {frame.intrinsics}, expected finite ones with focal lengths above 0 px"
            )
        if not 0.0 < frame.depth_unit <= 0.1:
            raise GeometryError(f"depth unit {frame.depth_unit:g} m, expected above 0 to 0.1 m")
        state = self._states.at(frame.stamp_ns)
        pose = self._kinematics.camera_pose(state.position, state.stance)
        if frame.depth_stamp_ns in (-1, frame.stamp_ns):
            return View(frame, pose, state.velocity, state.uncertainty)
        apart_ns = abs(frame.depth_stamp_ns - frame.stamp_ns)
        if apart_ns > MAX_APART_NS:
            raise GeometryError(
                f"depth was taken {apart_ns * 1e-9:.2f} s apart from the colours, limit "
                f"{MAX_APART_NS * 1e-9:g} s: what is seen may have changed"
            )
        then = self._states.at(frame.depth_stamp_ns)
        return View(
            frame,
            pose,
            state.velocity,
            state.uncertainty,
            self._kinematics.camera_pose(then.position, then.stance),
            then.uncertainty,
        )
