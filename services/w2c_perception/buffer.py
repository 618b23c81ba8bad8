"""The memory of the last seconds: pictures by their stamp, joint angles by time."""

from bisect import bisect_left
from collections import deque
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from w2c.depth import decode_depth
from w2c.errors import RefusedError
from w2c.geometry import Intrinsics, Matrix
from w2c.messages import Array, CameraFrame

MAX_GAP_NS = 100_000_000
"""Joint angles further apart are not interpolated: the robot may have gone there and back."""


class View:
    """One picture with its depth, and where the camera and the arms were."""

    def __init__(
        self, frame: CameraFrame, world_from_camera: Matrix, arms: Array, pose_error: float
    ) -> None:
        self.stamp_ns = frame.stamp_ns
        self.width, self.height = frame.width, frame.height
        self.intrinsics = Intrinsics(*frame.intrinsics)
        self.world_from_camera = world_from_camera
        self.arms = arms
        """(n, 2, 3) the bones of the robot's arms then, in the world [m]"""
        self.pose_error = pose_error
        """How far off the camera may be, from the time between the joint angles [m]"""
        self.depth_unit = frame.depth_unit
        self._encoded = frame.depth

    def unpack_depth(self) -> npt.NDArray[np.float32]:
        """Return the depth (h, w) [m], 0 = unknown. Not kept: unpacked it is fifty times as large.

        Raises:
            MessageError: the camera sent something else.
        """
        if not self._encoded:
            return np.zeros((self.height, self.width), np.float32)
        return decode_depth(self._encoded, self.width, self.height, self.depth_unit)


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
class InterpolatedPosition:
    """Joint angles between two measurements."""

    position: Array
    """(n,) [rad]"""
    uncertainty: float
    """How far any angle may be off, for not being measured at that instant [rad]"""


class StateBuffer:
    """Joint angles of the last seconds."""

    def __init__(self, history_s: float) -> None:
        self._history_ns = round(history_s * 1e9)
        self._stamps: deque[int] = deque()
        self._positions: deque[Array] = deque()

    def add(self, stamp_ns: int, position: Array) -> bool:
        """Remember joint angles (n,) [rad]. Returns False where time jumped back: memory is new."""
        continues = not self._stamps or stamp_ns > self._stamps[-1]
        if not continues:
            if stamp_ns == self._stamps[-1]:
                return True
            self._stamps.clear()
            self._positions.clear()
        self._stamps.append(stamp_ns)
        self._positions.append(position)
        while stamp_ns - self._stamps[0] > self._history_ns:
            self._stamps.popleft()
            self._positions.popleft()
        return continues

    @property
    def newest_ns(self) -> int:
        """Return the stamp of the newest joint angles, -1 before the first."""
        return self._stamps[-1] if self._stamps else -1

    def at(self, stamp_ns: int) -> InterpolatedPosition:
        """Return the joint angles at an instant, linear between the two measurements around it.

        Raises:
            RefusedError: it is before the first, after the last, or in a gap.
        """
        if not self._stamps:
            raise RefusedError("no joint angles have come yet; is the robot running?")
        if not self._stamps[0] <= stamp_ns <= self._stamps[-1]:
            raise RefusedError(
                f"joint angles reach from {self._stamps[0]} to {self._stamps[-1]} ns, "
                f"{stamp_ns} ns is outside"
            )
        after = bisect_left(self._stamps, stamp_ns)
        if self._stamps[after] == stamp_ns:
            return InterpolatedPosition(self._positions[after], 0.0)
        start, end = self._stamps[after - 1], self._stamps[after]
        if end - start > MAX_GAP_NS:
            raise RefusedError(
                f"no joint angles for {(end - start) * 1e-6:.0f} ms around {stamp_ns} ns, limit "
                f"{MAX_GAP_NS * 1e-6:.0f} ms"
            )
        share = (stamp_ns - start) / (end - start)
        before_position, after_position = self._positions[after - 1], self._positions[after]
        position = (1.0 - share) * before_position + share * after_position
        return InterpolatedPosition(position, self._bend(after) * 0.5 * share * (1.0 - share))

    def _bend(self, after: int) -> float:
        """Return the largest second difference [rad] of the angles around an interval.

        A motion q(t) misses its chord by s (1 - s) / 2 times it, where s is the share of the
        interval. Without neighbours to tell, the step itself is taken.
        """
        rows = [
            self._positions[i]
            for i in range(max(0, after - 2), min(len(self._positions), after + 2))
        ]
        if len(rows) < 3:
            return float(np.abs(rows[-1] - rows[0]).max())
        return float(np.abs(np.diff(np.stack(rows), n=2, axis=0)).max())
