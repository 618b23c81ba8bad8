"""Which picture the operator sees, and where the target is on it.

A target belongs to the frame it was chosen in. On a newer picture it is the target's 3D point,
projected with the pose the camera had at that picture. Where that cannot be known, the page stays
on the target's own picture while the operator has to decide about it, and says so.
"""

from collections import OrderedDict
from dataclasses import dataclass, replace

from w2c import geometry
from w2c.errors import GeometryError
from w2c.messages import CameraFrame, CameraView, Target
from w2c_console.page import LabelledBox, Marker

FRAMES_KEPT = 30
"""About 10 s of pictures: longer than a sentence takes to be understood"""
PINS_KEPT = 16
"""Pictures of the last utterances, clicks and targets, kept however long an answer takes"""
VIEWS_KEPT = 120
POSE_PATIENCE_NS = 2_000_000_000
"""How much older than the newest a picture may be for the sake of a known camera pose [ns]"""
BOX_SHIFT_LIMIT = 3.0
"""Boxes and areas are drawn on other pictures than their own while the target moved by less [px]"""
NO_DEPTH = "The target has no depth: its place is known in its own picture only."
NO_POSE = "The camera's pose is not known: perception is silent."


@dataclass(frozen=True)
class Frame:
    """A picture as the page gets it."""

    sequence: int
    stamp_ns: int
    width: int
    height: int
    jpeg: bytes
    arrived_ns: int
    """Clock of the console [ns]"""
    robot_boot_id: str = ""
    """Of the robot in it; "" = not known"""


@dataclass(frozen=True)
class Scene:
    """A picture with what is drawn on it."""

    frame: Frame | None
    marker: Marker | None = None
    boxes: tuple[LabelledBox, ...] = ()
    frozen: bool = False
    notice: str = ""
    area_stamp_ns: int = -1
    """Of the picture whose allowed area fits this one too; -1: of none"""
    destination: Marker | None = None
    """The confirmed target, where another one is shown meanwhile"""
    moving_to: str = ""
    """Its id, in the picture or not"""


class FrameHistory:
    """The last pictures, the pictures that utterances refer to, and the camera's pose at each."""

    def __init__(self) -> None:
        self._frames: OrderedDict[int, Frame] = OrderedDict()
        self._pinned: OrderedDict[int, Frame] = OrderedDict()
        self._views: OrderedDict[int, CameraView] = OrderedDict()
        self._sequence = 0

    @property
    def newest(self) -> Frame | None:
        """The picture that arrived last."""
        return next(reversed(self._frames.values()), None)

    def add_frame(self, message: CameraFrame, arrived_ns: int) -> None:
        """Take a new picture in."""
        newest = self.newest
        if newest is not None and _began_anew(newest, message):
            # Old stamps may come again with other contents.
            self._frames.clear()
            self._pinned.clear()
            self._views.clear()
        self._sequence += 1
        self._frames[message.stamp_ns] = Frame(
            self._sequence,
            message.stamp_ns,
            message.width,
            message.height,
            message.jpeg,
            arrived_ns,
            message.robot_boot_id,
        )
        _trim(self._frames, FRAMES_KEPT)

    def add_view(self, view: CameraView) -> None:
        """Take in where the camera was."""
        self._views[view.stamp_ns] = view
        _trim(self._views, VIEWS_KEPT)

    def pin(self, stamp_ns: int) -> None:
        """Keep this picture: something was said about it."""
        frame = self.get(stamp_ns)
        if frame is not None:
            self._pinned[stamp_ns] = frame
            self._pinned.move_to_end(stamp_ns)
            _trim(self._pinned, PINS_KEPT)

    def get(self, stamp_ns: int) -> Frame | None:
        """Return the picture with this stamp, if it is still kept."""
        return self._frames.get(stamp_ns) or self._pinned.get(stamp_ns)

    def view(self, stamp_ns: int) -> CameraView | None:
        """Return where the camera was at this picture, if that is known."""
        view, frame = self._views.get(stamp_ns), self.get(stamp_ns)
        if view is None or frame is None:
            return view
        return view if _same(view.robot_boot_id, frame.robot_boot_id) else None

    def newest_with_view(self, patience_ns: int) -> Frame | None:
        """Return the newest picture whose camera pose is known, unless it is too old."""
        newest = self.newest
        for frame in reversed(self._frames.values()):
            if newest is None or newest.stamp_ns - frame.stamp_ns > patience_ns:
                return None
            if self.view(frame.stamp_ns) is not None:
                return frame
        return None


def compose(
    history: FrameHistory,
    target: Target | None,
    destination: Target | None = None,
    *,
    live: bool,
) -> Scene:
    """Return what the operator should see now.

    Args:
        history: pictures and camera poses.
        target: the current target.
        destination: what the robot moves to, be it this target or another; None: it does not.
        live: the operator asked for the newest picture, even if the target cannot be drawn on it.
    """
    scene = _with_target(history, target, live=live)
    if destination is None or target is None or target.target_id == destination.target_id:
        return scene
    marker = None if scene.frame is None else _marker_on(history, scene.frame, destination)
    return replace(scene, destination=marker, moving_to=destination.target_id)


def _with_target(history: FrameHistory, target: Target | None, *, live: bool) -> Scene:
    newest = history.newest
    if newest is None or target is None or target.state == "abandoned":
        return Scene(newest)
    if newest.stamp_ns == target.frame_stamp_ns:
        return _on_own_frame(newest, target)
    if target.point is None:
        return _without_place(history, newest, target, NO_DEPTH, live=live)
    posed = history.newest_with_view(POSE_PATIENCE_NS)
    if posed is None:
        return _without_place(history, newest, target, NO_POSE, live=live)
    return _on_newer_frame(history, posed, target)


def project(view: CameraView, target: Target) -> tuple[float, float] | None:
    """Return the pixel (u, v) of the target's point; None where the picture does not show it."""
    if target.point is None:
        return None
    point_in_camera = geometry.apply(geometry.inverse(view.world_from_camera), target.point)
    try:
        u, v = geometry.Intrinsics(*view.intrinsics).pixel_from_point(point_in_camera)
    except GeometryError:  # behind the camera: an ordinary answer here
        return None
    inside = 0 <= u < view.width and 0 <= v < view.height
    return (float(u), float(v)) if inside else None


def _same(boot_id: str, other: str) -> bool:
    """Tell whether two boot ids may be of one process: one that is not known may be any."""
    return not boot_id or not other or boot_id == other


def _began_anew(newest: Frame, message: CameraFrame) -> bool:
    """Tell whether a picture is the first of a robot that started anew."""
    if newest.robot_boot_id and message.robot_boot_id:
        return newest.robot_boot_id != message.robot_boot_id
    return message.stamp_ns < newest.stamp_ns


def _on_own_frame(frame: Frame, target: Target) -> Scene:
    return Scene(
        frame, _marker(target, target.u, target.v), _boxes(target), area_stamp_ns=_area(target)
    )


def _on_newer_frame(history: FrameHistory, frame: Frame, target: Target) -> Scene:
    if frame.stamp_ns == target.frame_stamp_ns:
        return _on_own_frame(frame, target)
    view = history.view(frame.stamp_ns)
    pixel = None if view is None else project(view, target)
    if pixel is None:
        return Scene(frame, notice="The target is outside the picture.")
    shift = max(abs(pixel[0] - target.u), abs(pixel[1] - target.v))
    if shift >= BOX_SHIFT_LIMIT:
        return Scene(frame, _marker(target, *pixel))
    return Scene(frame, _marker(target, *pixel), _boxes(target), area_stamp_ns=_area(target))


def _without_place(
    history: FrameHistory, newest: Frame, target: Target, reason: str, *, live: bool
) -> Scene:
    own = history.get(target.frame_stamp_ns)
    if target.state != "proposed":
        return Scene(newest, notice=f"The target is not drawn. {reason}")
    if live:
        return Scene(newest, notice="Live picture: the target cannot be drawn on it.")
    if own is None:
        notice = (
            f"The target is not drawn: its picture is no longer kept. {reason} Ask for it again."
        )
        return Scene(newest, notice=notice)
    scene = _on_own_frame(own, target)
    return replace(scene, frozen=True, notice=f"Picture frozen. {reason}")


def _marker_on(history: FrameHistory, frame: Frame, target: Target) -> Marker | None:
    """Return where a target is on a picture; None where that is not known, or outside."""
    if frame.stamp_ns == target.frame_stamp_ns:
        return _marker(target, target.u, target.v)
    view = history.view(frame.stamp_ns)
    pixel = None if view is None else project(view, target)
    return None if pixel is None else _marker(target, *pixel)


def _marker(target: Target, u: float, v: float) -> Marker:
    return Marker(target.target_id, u, v, target.state, corrected=target.corrections > 0)


def _area(target: Target) -> int:
    """Return the picture whose allowed area matters: while the operator decides."""
    return target.frame_stamp_ns if target.state == "proposed" else -1


def _boxes(target: Target) -> tuple[LabelledBox, ...]:
    phrases = target.phrases + [""] * (len(target.boxes) - len(target.phrases))
    return tuple(
        LabelledBox(box.left, box.top, box.right, box.bottom, phrase)
        for box, phrase in zip(target.boxes, phrases, strict=False)
    )


def _trim(items: OrderedDict[int, Frame] | OrderedDict[int, CameraView], limit: int) -> None:
    while len(items) > limit:
        items.popitem(last=False)
