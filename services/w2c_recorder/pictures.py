"""The pictures of a recording, found by reference: few are kept in memory."""

from collections.abc import Iterable

from w2c import messages as m
from w2c import topics
from w2c.bus import Input
from w2c.errors import RecordingError
from w2c.geometry import apply, inverse
from w2c_recorder.history import FrameReference, History, latest
from w2c_recorder.overlay import Overlay, overlay_of
from w2c_recorder.reading import Recording

Reference = tuple[str, str, int]
"""Key, boot id and sequence number"""


def reference(source: Input) -> Reference:
    """Return a reference that can be a key of a dictionary."""
    return source.key, source.boot_id, source.sequence


def frames_of(
    recording: Recording, wanted: Iterable[FrameReference]
) -> dict[Reference, m.CameraFrame]:
    """Read a recording again for some pictures. What is not there is missing in the result."""
    pending = {reference(frame.source): frame.at_ns for frame in wanted}
    found: dict[Reference, m.CameraFrame] = {}
    for recorded in recording.of(topics.CAMERA_FRAME):
        envelope, message = recorded.envelope, recorded.message
        if envelope is None or not isinstance(message, m.CameraFrame):
            continue
        name = (recorded.key, envelope.boot_id, envelope.sequence)
        if name in pending:
            found[name] = message
        if len(found) == len(pending):
            break
    return found


def view_of(recording: Recording, frame: m.CameraFrame) -> m.CameraView | None:
    """Return where the camera was when it took a picture; None where nobody said."""
    for recorded in recording.of(topics.CAMERA_VIEW):
        view = recorded.message
        if not isinstance(view, m.CameraView) or view.stamp_ns != frame.stamp_ns:
            continue
        if "" in (view.robot_boot_id, frame.robot_boot_id) or (
            view.robot_boot_id == frame.robot_boot_id
        ):
            return view
    return None


def frame_at(
    recording: Recording, history: History, at_ns: int, *, newest: bool = False
) -> tuple[m.CameraFrame, Overlay]:
    """Return the picture of an instant and what is to be drawn over it.

    That is the picture which the present target was chosen in, with all that was found in it; or
    the newest picture, with the target projected into it.

    Raises:
        RecordingError: there is no such picture in the recording.
    """
    turn = history.target_at(at_ns)
    target = None if turn is None else turn.message.target
    chosen = None if target is None else history.frame_of(target, at_ns)
    wanted = latest(history.frames, at_ns) if newest or chosen is None else chosen
    if wanted is None:
        raise RecordingError(
            f"no picture was recorded before {history.seconds(at_ns):.3f} s; "
            f"there are {len(history.frames)} in all"
        )
    frame = frames_of(recording, [wanted])[reference(wanted.source)]
    if target is None:
        return frame, Overlay()
    if wanted is chosen:
        return frame, overlay_of(history, target)
    return frame, _projected(recording, frame, target)


def _projected(recording: Recording, frame: m.CameraFrame, target: m.Target) -> Overlay:
    """Return the target's point as it is seen in another picture; nothing where it is not seen."""
    return projected(view_of(recording, frame), target)


def projected(view: m.CameraView | None, target: m.Target) -> Overlay:
    """Return the target's point as another picture shows it, by where the camera was then."""
    if target.point is None:
        return Overlay(label=f"{target.target_id} has no point in the world")
    if view is None:
        return Overlay(label="where the camera was is not in the recording")
    x, y, z = apply(inverse(view.world_from_camera), target.point)
    if z <= 0.0:
        return Overlay(label=f"{target.target_id} is behind the camera")
    fx, fy, cx, cy = view.intrinsics
    return Overlay(
        point=(float(fx * x / z + cx), float(fy * y / z + cy)),
        label=f"{target.target_id}, {target.state}",
    )
