"""The memory of the last seconds: pictures by their stamp, joint angles by time."""

from bisect import bisect_left
from collections import deque
from dataclasses import dataclass

import numpy as np

from w2c.depth import unpack_depth
from w2c.errors import RefusedError
from w2c.geometry import Intrinsics, inverse
from w2c.messages import Array, CameraFrame
from w2c.stance import Stance
from w2c_perception.pose import CameraPose
from w2c_perception.window import DepthPicture

MAX_GAP_NS = 100_000_000
"""Joint angles further apart are not interpolated: the robot may have gone there and back."""

NEIGHBOURS = 2
"""Measurements before an instant, and after it, that say where the joints were then"""
CAMERA_REACH = 2.0
"""A joint that is off by an angle moves what the camera sees by no more than this times the
angle [m]"""
TYPICAL_DEPTH = 1.0
"""Of what a hand is sent to, where depth is not known [m]"""


class View:
    """One picture with its depth, and where the camera and the arms were."""

    def __init__(
        self,
        frame: CameraFrame,
        pose: CameraPose,
        velocity: Array,
        angle_error: float = 0.0,
        depth_pose: CameraPose | None = None,
        depth_angle_error: float = 0.0,
    ) -> None:
        """Take a picture.

        Args:
            frame: as it came.
            pose: of the camera when it took the colours.
            velocity: (n,) of the joints then [rad/s].
            angle_error: how far any joint angle may be off, for not being measured then [rad].
            depth_pose: of the camera when it took depth; None: with the colours.
            depth_angle_error: as `angle_error`, for that instant [rad].
        """
        self.frame = frame
        self.stamp_ns = frame.stamp_ns
        self.depth_pose = depth_pose or pose
        """Places what depth shows in the world"""
        self.depth_from_colours = (
            inverse(depth_pose.world_from_camera) @ pose.world_from_camera if depth_pose else None
        )
        """(4, 4) from the camera when it took the colours to when it took depth; None: at once"""
        self._depth_angle_error = depth_angle_error if depth_pose else angle_error
        self.width, self.height = frame.width, frame.height
        self.intrinsics = Intrinsics(*frame.intrinsics)
        self.pose = pose
        self.velocity = velocity
        self.angle_error = angle_error
        self.depth_unit = frame.depth_unit

    def unpack_depth(self) -> DepthPicture:
        """Return the depth (h, w) [m], 0 = unknown. Not kept here, see `DepthMemory`.

        Raises:
            MessageError: the camera sent something else.
        """
        if not self.frame.depth:
            return np.zeros((self.height, self.width), np.float32)
        return unpack_depth(self.frame.depth, self.width, self.height, self.depth_unit)

    def blur(self, depth: DepthPicture, u: float, v: float, lag_s: float) -> float:
        """Return how far depth may be beside the colours at a pixel [px]; 0 outside of it.

        Args:
            depth: (h, w) [m].
            u: in the depth picture, to the right [px].
            v: down [px].
            lag_s: how far apart in time both may be, beyond what their stamps say [s].
        """
        if not (0.0 <= u < self.width and 0.0 <= v < self.height):
            return 0.0
        z = float(depth[int(v), int(u)]) or TYPICAL_DEPTH
        moved = 0.0
        if lag_s > 0.0:
            moved = lag_s * self.pose.pixel_speed(self.velocity, self.intrinsics, u, v, z)
        if self.depth_from_colours is not None:
            turned = self.angle_error + self._depth_angle_error
            moved += self.intrinsics.fx * turned * (1.0 + CAMERA_REACH / z)
        return moved

    def pose_error(self, point: Array, joint_error: float) -> float:
        """Return how far off a point (3,) may be, for where the camera was when it took depth [m].

        Args:
            point: in the world [m].
            joint_error: constant error that each joint angle may have [rad].
        """
        of_joints = self.depth_pose.error(point, joint_error)
        return of_joints + CAMERA_REACH * self._depth_angle_error


class ViewBuffer:
    """Views of the last seconds, oldest first."""

    def __init__(self, history_s: float, max_frames: int) -> None:
        self._history_ns = round(history_s * 1e9)
        self._max_frames = max_frames
        self._views: dict[int, View] = {}

    def add(self, view: View) -> None:
        """Remember a view, and forget what has become too old or too many.

        A view of the same instant replaces the former. Time that jumps back is a robot that
        started anew: what was before means nothing then.
        """
        if self._views and view.stamp_ns < min(self._views):
            self._views.clear()
        self._views.pop(view.stamp_ns, None)
        self._views[view.stamp_ns] = view
        newest = max(self._views)
        for stamp in sorted(self._views):
            if len(self._views) <= self._max_frames and newest - stamp <= self._history_ns:
                break
            del self._views[stamp]

    def clear(self) -> None:
        """Forget everything."""
        self._views.clear()

    def stamps(self) -> list[int]:
        """Return the stamps of what is remembered [ns], oldest first."""
        return sorted(self._views)

    def get(self, stamp_ns: int) -> View:
        """Return the view of a stamp.

        Raises:
            RefusedError: it is not here; the message says what is.
        """
        view = self._views.get(stamp_ns)
        if view is not None:
            return view
        if not self._views:
            raise RefusedError(
                f"no picture of stamp {stamp_ns} ns: none has come yet; is the camera running?"
            )
        oldest, newest = min(self._views), max(self._views)
        if stamp_ns < oldest:
            why = f"it is {(oldest - stamp_ns) * 1e-9:.1f} s older than the oldest"
        elif stamp_ns > newest:
            why = f"it is {(stamp_ns - newest) * 1e-9:.1f} s newer than the newest"
        else:
            why = "no picture was taken then"
        raise RefusedError(
            f"no picture of stamp {stamp_ns} ns in memory: {why}; there are "
            f"{len(self._views)} from {oldest} to {newest} ns. Choose the pixel in a newer picture"
        )


@dataclass(frozen=True)
class InterpolatedState:
    """The robot between two measurements."""

    position: Array
    """(n,) [rad]"""
    velocity: Array
    """(n,) from one measurement to the other [rad/s]"""
    uncertainty: float
    """How far any angle may be off, for not being measured at that instant [rad]"""
    stance: Stance
    """The feet that stand at both"""


class StateBuffer:
    """Joint angles and stances of the last seconds."""

    def __init__(self, history_s: float) -> None:
        self._history_ns = round(history_s * 1e9)
        self._stamps: deque[int] = deque()
        self._positions: deque[Array] = deque()
        self._stances: deque[Stance | None] = deque()

    def add(self, stamp_ns: int, position: Array, stance: Stance | None) -> bool:
        """Remember joint angles (n,) [rad] and the stance, None where no foot stands.

        Returns False where time jumped back: memory is new.
        """
        continues = not self._stamps or stamp_ns > self._stamps[-1]
        if not continues:
            if stamp_ns == self._stamps[-1]:
                return True
            self.clear()
        self._stamps.append(stamp_ns)
        self._positions.append(position)
        self._stances.append(stance)
        while stamp_ns - self._stamps[0] > self._history_ns:
            self._stamps.popleft()
            self._positions.popleft()
            self._stances.popleft()
        return continues

    def clear(self) -> None:
        """Forget everything."""
        self._stamps.clear()
        self._positions.clear()
        self._stances.clear()

    @property
    def newest_ns(self) -> int:
        """Return the stamp of the newest joint angles, -1 before the first."""
        return self._stamps[-1] if self._stamps else -1

    def at(self, stamp_ns: int) -> InterpolatedState:
        """Return the robot at an instant, linear between the two measurements around it.

        Raises:
            RefusedError: it is before the first, after the last, in a gap, or no foot stood.
        """
        if not self._stamps:
            raise RefusedError("no joint angles have come yet; is the robot running?")
        if not self._stamps[0] <= stamp_ns <= self._stamps[-1]:
            raise RefusedError(
                f"joint angles reach from {self._stamps[0]} to {self._stamps[-1]} ns, "
                f"{stamp_ns} ns is outside"
            )
        after = bisect_left(self._stamps, stamp_ns)
        exact = self._stamps[after] == stamp_ns
        before = max(0, after - 1)
        start, end = self._stamps[before], self._stamps[after]
        if end - start > MAX_GAP_NS and not exact:
            raise RefusedError(
                f"no joint angles for {(end - start) * 1e-6:.0f} ms around {stamp_ns} ns, limit "
                f"{MAX_GAP_NS * 1e-6:.0f} ms"
            )
        step = self._positions[after] - self._positions[before]
        velocity = step / max(1e-9, 1e-9 * (end - start))
        share = (stamp_ns - start) / (end - start) if end > start else 1.0
        return InterpolatedState(
            position=self._positions[after] - (1.0 - share) * step,
            velocity=velocity,
            uncertainty=0.0 if exact else self._bend(after) * 0.5 * share * (1.0 - share),
            stance=self._stance(after if exact else before, after),
        )

    def _stance(self, before: int, after: int) -> Stance:
        """Return the stance with fewer feet of two: a foot that is being lifted says nothing."""
        first, second = self._stances[before], self._stances[after]
        if first is None or second is None or first.world != second.world:
            raise RefusedError(
                "no foot stood on the ground then: where the camera was cannot be known"
            )
        return first if sum(first.standing) < sum(second.standing) else second

    def _bend(self, after: int) -> float:
        """Return the largest second difference [rad] of the angles around an interval.

        A motion q(t) misses its chord by s (1 - s) / 2 times it, where s is the share of the
        interval. Without neighbours to tell, the step itself is taken.
        """
        rows = [
            self._positions[i]
            for i in range(
                max(0, after - NEIGHBOURS), min(len(self._positions), after + NEIGHBOURS)
            )
        ]
        if len(rows) < 3:
            return float(np.abs(rows[-1] - rows[0]).max())
        return float(np.abs(np.diff(np.stack(rows), n=2, axis=0)).max())
