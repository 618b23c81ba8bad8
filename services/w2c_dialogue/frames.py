"""The pictures of the last seconds, so that a pixel belongs to the picture the operator saw."""

import threading
from collections import OrderedDict
from dataclasses import replace

import numpy as np

from w2c import geometry
from w2c.errors import GeometryError, NotNowError, RefusedError
from w2c.messages import Array, CameraView
from w2c_dialogue.interfaces import Frame

RESTARTED = (
    "The robot started anew since that picture was taken: it may stand elsewhere now. Look at the "
    "live picture, then name the place again."
)
"""Why nothing comes of a picture, for the operator"""
KEPT_FRAMES = 100
"""Half a minute at 3 frames a second; a JPEG is about 200 kB, depth is not kept."""
FIRST_TAKES = 3.0
"""A dialogue that has just begun waits so many times as long: on a busy machine it takes seconds
until the camera knows who listens."""
STAND_IN_AGE_NS = 1_000_000_000
"""So far in time may the picture be that stands in for one that was lost."""
STAND_IN_SHIFT_M = 0.005
STAND_IN_TURN = 0.004
"""Of any entry of the rotation; 3 pixels of 1280, as much as the shift at arm's length."""
DEFAULT_PIXELS_PER_CM = 10.0


class FrameStore:
    """Frames of one robot by stamp, with the camera's pose where it is known. Thread-safe.

    A robot that starts anew counts time from zero again: with its first picture all that came
    before is forgotten.
    """

    def __init__(self, kept: int = KEPT_FRAMES) -> None:
        self._kept = kept
        self._boot_id = ""
        self._frames: OrderedDict[int, Frame] = OrderedDict()
        self._views: OrderedDict[int, CameraView] = OrderedDict()
        self._waited_in_vain = False
        self._changed = threading.Condition()

    def add_frame(self, frame: Frame) -> None:
        """Keep a picture, and forget the oldest."""
        with self._changed:
            if self._began_anew(frame):
                self._frames.clear()
            self._boot_id = frame.robot_boot_id or self._boot_id
            self._frames[frame.stamp_ns] = frame
            while len(self._frames) > self._kept:
                self._frames.popitem(last=False)
            self._changed.notify_all()

    def add_view(self, view: CameraView) -> None:
        """Keep where the camera was."""
        with self._changed:
            self._views[view.stamp_ns] = view
            while len(self._views) > self._kept:
                self._views.popitem(last=False)
            self._changed.notify_all()

    def current(self, frame: Frame) -> bool:
        """Tell whether a picture is of the robot that sends now, as far as both are known."""
        with self._changed:
            return _same(frame.robot_boot_id, self._boot_id)

    def find(self, stamp_ns: int, robot_boot_id: str = "", wait_s: float = 0.0) -> Frame:
        """Return the picture of a stamp, the newest for -1; waits for it and for its camera pose.

        A picture that reached the operator and was lost on its way here is stood in for by its
        neighbour in time, when the camera was in the same place.

        Args:
            stamp_ns: Of the picture that the operator saw; -1 = none.
            robot_boot_id: Of the robot in it; "" = not checked.
            wait_s: How long it, and its pose, may still be on their way [s]; the very first one
                may take `FIRST_TAKES` times as long, once: where no camera sends, that is said
                at once from then on.

        Raises:
            NotNowError: there is no such picture; says what to do.
            RefusedError: it is of before a robot's restart.
        """
        with self._changed:
            if stamp_ns >= 0 and not _same(robot_boot_id, self._boot_id):
                raise RefusedError(RESTARTED)
            patience_s = self._patience_s(stamp_ns, wait_s)
            self._changed.wait_for(lambda: self._complete(stamp_ns), timeout=patience_s)
            if patience_s > 0.0:
                self._waited_in_vain = not self._frames
            if not self._frames and stamp_ns < 0:
                raise NotNowError(
                    "I have no picture: the camera does not send. Check `w2c status`, then say it "
                    "again."
                )
            frame = self._frames.get(self._resolve(stamp_ns)) or self._stand_in(stamp_ns)
            if frame is None:
                raise NotNowError(
                    f"The picture you saw (stamp {stamp_ns}) is not among the last "
                    f"{len(self._frames)} that I keep. "
                    "Look at the live picture, then say it again."
                )
            return replace(frame, view=self._view(frame))

    def _patience_s(self, stamp_ns: int, wait_s: float) -> float:
        """Return how long to wait for a picture [s]."""
        if self._frames:
            return wait_s
        return 0.0 if stamp_ns < 0 and self._waited_in_vain else FIRST_TAKES * wait_s

    def _stand_in(self, stamp_ns: int) -> Frame | None:
        """Return the nearest picture that shows what a lost one showed; None where none does.

        The camera stood still if it was in one place at the nearest pictures before and after, or
        at the lost one itself, whose pose comes on a way of its own.
        """
        near = [stamp for stamp in self._frames if abs(stamp - stamp_ns) <= STAND_IN_AGE_NS]
        before = max((stamp for stamp in near if stamp < stamp_ns), default=None)
        after = min((stamp for stamp in near if stamp > stamp_ns), default=None)
        around = [self._views.get(stamp) for stamp in (before, stamp_ns, after) if stamp]
        known = [view for view in around if view is not None]
        if len(known) < 2 or not all(_same_place(known[0], view) for view in known[1:]):
            return None
        nearest = min(near, key=lambda stamp: abs(stamp - stamp_ns))
        return self._frames[nearest]

    def _resolve(self, stamp_ns: int) -> int:
        """Return the stamp meant by -1: the newest picture whose pose is known, else the newest."""
        if stamp_ns >= 0 or not self._frames:
            return stamp_ns
        known = (stamp for stamp, frame in reversed(self._frames.items()) if self._view(frame))
        return next(known, next(reversed(self._frames)))

    def _complete(self, stamp_ns: int) -> bool:
        """Say whether nothing more is to be expected for a stamp."""
        stamp = self._resolve(stamp_ns)
        if stamp not in self._frames:
            # A picture that the operator saw was sent: the first one may still be on its way.
            return bool(self._frames) and stamp < next(reversed(self._frames))
        return not self._views or self._view(self._frames[stamp]) is not None

    def _view(self, frame: Frame) -> CameraView | None:
        """Return where the camera was at a picture; None where it is not known."""
        view = self._views.get(frame.stamp_ns)
        known = view is not None and _same(view.robot_boot_id, frame.robot_boot_id)
        return view if known else None

    def _began_anew(self, frame: Frame) -> bool:
        """Tell whether a picture is the first of a robot that started anew."""
        if not self._frames or (frame.robot_boot_id and self._boot_id):
            return not _same(frame.robot_boot_id, self._boot_id)
        return frame.stamp_ns < min(self._frames)


def _same_place(one: CameraView, other: CameraView) -> bool:
    """Tell whether a point is at the same pixel for two views, to a few pixels."""
    if not _same(one.robot_boot_id, other.robot_boot_id):
        return False
    change = np.abs(np.asarray(one.world_from_camera) - np.asarray(other.world_from_camera))
    return bool(
        np.max(change[:3, 3]) <= STAND_IN_SHIFT_M and np.max(change[:3, :3]) <= STAND_IN_TURN
    )


def _same(boot_id: str, other: str) -> bool:
    """Tell whether two boot ids may be of one process: one that is not known may be any."""
    return not boot_id or not other or boot_id == other


def project(point: Array, view: CameraView) -> tuple[float, float] | None:
    """Return the pixel of a point (3,) of the world [m]; None where it is not in the picture."""
    in_camera = geometry.apply(geometry.inverse(np.asarray(view.world_from_camera)), point)
    try:
        u, v = geometry.Intrinsics(*view.intrinsics).pixel_from_point(in_camera)
    except GeometryError:
        return None
    return (u, v) if 0 <= u <= view.width and 0 <= v <= view.height else None


def pixels_per_cm(point: Array | None, view: CameraView | None) -> float:
    """Return the scale of the picture at a point of the world, f / z; 10 px without depth."""
    if point is None or view is None:
        return DEFAULT_PIXELS_PER_CM
    depth = float(geometry.apply(geometry.inverse(np.asarray(view.world_from_camera)), point)[2])
    if depth < 0.05:
        return DEFAULT_PIXELS_PER_CM
    return 0.01 * view.intrinsics[0] / depth
