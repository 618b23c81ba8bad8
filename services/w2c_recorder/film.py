"""The camera's pictures as a film, with target, boxes, heat and captions."""

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import cv2

from w2c import messages as m
from w2c import topics
from w2c.errors import ConfigError, RecordingError
from w2c_recorder.drawing import BgrImage, caption, decode_picture, draw
from w2c_recorder.history import History, history_of, latest
from w2c_recorder.overlay import Overlay, overlay_of
from w2c_recorder.pictures import projected
from w2c_recorder.reading import Recording

FRAMES_PER_SECOND = 10
CAPTION_S = 6.0
"""How long words stay on the screen"""
LONGEST_CAPTION = 110
LONGEST_STILL_S = 60.0
"""A camera that was silent for longer is shown for this long"""


def write_film(recording: Recording, out: Path) -> int:
    """Write an MP4 in the time of the recording; each picture stays until the next.

    Returns:
        The number of recorded pictures in it.

    Raises:
        RecordingError: there is no picture in the recording that can be read, or no room for the
            film.
        ConfigError: the file cannot be written.
    """
    history = history_of(recording)
    if not history.frames:
        raise RecordingError(f"{recording.path} holds no picture of the camera")
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ConfigError(
            f"{out} cannot be written: {error.strerror}; choose another --out"
        ) from error
    writer: cv2.VideoWriter | None = None
    size, count, frames = (0, 0), 0, 0
    try:
        for drawn, repeats in _drawn(recording, history):
            if writer is None:
                size = (drawn.shape[1], drawn.shape[0])
                code = cv2.VideoWriter.fourcc(*"mp4v")
                writer = cv2.VideoWriter(str(out), code, FRAMES_PER_SECOND, size)
                if not writer.isOpened():
                    raise ConfigError(f"{out} cannot be written as MP4; choose another --out")
            same = (drawn.shape[1], drawn.shape[0]) == size
            fitting = drawn if same else cv2.resize(drawn, size)  # another camera on the way
            for _ in range(repeats):
                writer.write(fitting)
            count += 1
            frames += repeats
    finally:
        if writer is not None:
            writer.release()
    if not count:
        raise RecordingError(f"{recording.path} holds no picture of the camera that can be read")
    _check_whole(out, frames)
    return count


def _check_whole(out: Path, frames: int) -> None:
    """Raise RecordingError where a film is not what was written: OpenCV tells of no full disk."""
    film = cv2.VideoCapture(str(out))
    found = round(film.get(cv2.CAP_PROP_FRAME_COUNT)) if film.isOpened() else 0
    film.release()
    if found < frames:
        raise RecordingError(
            f"{out} has {found} of {frames} frames; make room, or choose another --out"
        )


def _drawn(recording: Recording, history: History) -> Iterator[tuple[BgrImage, int]]:
    """Yield each picture as drawn, and for how many frames it is shown."""
    views = {
        recorded.message.stamp_ns: recorded.message
        for recorded in recording.of(topics.CAMERA_VIEW)
        if isinstance(recorded.message, m.CameraView)
    }
    step_ns = 10**9 // FRAMES_PER_SECOND
    shown_ns = 0
    ends = [frame.at_ns for frame in history.frames[1:]] + [history.end_ns + step_ns]
    pictures = (one for one in recording.of(topics.CAMERA_FRAME))
    pixels: BgrImage | None = None
    for end_ns, recorded in zip(ends, pictures, strict=False):
        frame = recorded.message
        if not isinstance(frame, m.CameraFrame):
            continue
        with suppress(RecordingError):  # one that is none is stood in for by the one before
            pixels = decode_picture(frame.jpeg)
        if pixels is None:
            continue
        shown_ns = max(shown_ns, recorded.log_time_ns)
        limit_ns = min(end_ns, shown_ns + round(LONGEST_STILL_S * 1e9))
        repeats = max(0, -(-(limit_ns - shown_ns) // step_ns))
        if repeats:
            image = draw(pixels, _overlay(history, frame, end_ns, views))
            caption(image, _captions(history, shown_ns, end_ns))
            yield image, repeats
            shown_ns += repeats * step_ns


def _overlay(
    history: History, frame: m.CameraFrame, until_ns: int, views: dict[int, m.CameraView]
) -> Overlay:
    """Return what is drawn over a picture that is on the screen until a time."""
    turn = history.target_at(until_ns)
    target = None if turn is None else turn.message.target
    if target is None or target.state == "abandoned":
        return Overlay()
    if target.frame_stamp_ns == frame.stamp_ns:
        return overlay_of(history, target)
    return projected(views.get(frame.stamp_ns), target)


def _captions(history: History, from_ns: int, until_ns: int) -> list[str]:
    status = latest(history.statuses, until_ns)
    lines = [f"{history.seconds(from_ns):.1f} s  {status.message.phase if status else ''}"]
    turn = latest(history.turns, until_ns)
    if turn is not None and from_ns - turn.at_ns < CAPTION_S * 1e9:
        said = [f'"{turn.message.text}"'] if turn.message.text else []
        lines += [line[:LONGEST_CAPTION] for line in (*said, turn.message.reply)]
    return lines
