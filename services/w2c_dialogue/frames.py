"""The pictures of the last seconds, so that a pixel belongs to the picture the operator saw."""

import threading
from collections import OrderedDict
from dataclasses import replace

import numpy as np

from w2c import geometry
from w2c.errors import GeometryError, RefusedError
from w2c.messages import Array, CameraView
from w2c_dialogue.interfaces import Frame

KEPT_FRAMES = 100
"""Half a minute at 3 frames a second; a JPEG is about 200 kB, depth is not kept."""
DEFAULT_PIXELS_PER_CM = 10.0


class FrameStore:
    """Frames by stamp, with the camera's pose where it is known. Thread-safe."""

    def __init__(self, kept: int = KEPT_FRAMES) -> None:
        self._kept = kept
        self._frames: OrderedDict[int, Frame] = OrderedDict()
        self._views: OrderedDict[int, CameraView] = OrderedDict()
        self._changed = threading.Condition()

    def add_frame(self, frame: Frame) -> None:
        """Keep a picture, and forget the oldest."""
        with self._changed:
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

    def find(self, stamp_ns: int, wait_s: float = 0.0) -> Frame:
        """Return the picture of a stamp, the newest for -1; waits for it and for its camera pose.

        Raises:
            RefusedError: there is no such picture; says what to do.
        """
        with self._changed:
            self._changed.wait_for(lambda: self._complete(stamp_ns), timeout=wait_s)
            if not self._frames:
                raise RefusedError(
                    "I have no picture: the camera does not send. Check `w2c status`, then say it "
                    "again."
                )
            frame = self._frames.get(self._resolve(stamp_ns))
            if frame is None:
                raise RefusedError(
                    f"The picture you saw (stamp {stamp_ns}) is not among the last "
                    f"{len(self._frames)} that I keep. "
                    "Look at the live picture, then say it again."
                )
            return replace(frame, view=self._views.get(frame.stamp_ns))

    def _resolve(self, stamp_ns: int) -> int:
        """Return the stamp meant by -1: the newest picture whose pose is known, else the newest."""
        if stamp_ns >= 0 or not self._frames:
            return stamp_ns
        known = [stamp for stamp in self._frames if stamp in self._views]
        return known[-1] if known else next(reversed(self._frames))

    def _complete(self, stamp_ns: int) -> bool:
        """Say whether nothing more is to be expected for a stamp."""
        stamp = self._resolve(stamp_ns)
        if stamp not in self._frames:
            return not self._frames or stamp < next(reversed(self._frames))
        return not self._views or stamp in self._views


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
