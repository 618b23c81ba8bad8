"""Pictures of a run, and the strip of them: what was shown, what was wanted, what came of it."""

from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt

from w2c.messages import Target
from w2c_evaluation.demo.picture import draw_target
from w2c_evaluation.scenarios.sight import ACCEPTED_M, Circle

Image = npt.NDArray[np.uint8]

WANTED = (80, 220, 80)
FRAME_SIZE = (512, 288)
"""Of one picture of the strip, width and height [px]"""
CAPTION_HEIGHT = 34
MOST_FRAMES = 8
FONT = cv2.FONT_HERSHEY_SIMPLEX


class Film:
    """Writes numbered pictures into a directory."""

    def __init__(self, directory: Path) -> None:
        directory.mkdir(parents=True, exist_ok=True)
        self._directory = directory
        self._captions: list[str] = []

    def show(self, jpeg: bytes, target: Target, wanted: Circle, said: str) -> None:
        """Keep what the operator sees: the target, and the wanted place as a green circle."""
        image = _decode(draw_target(jpeg, target))
        if image is not None:
            outline = outline_of(wanted)
            cv2.polylines(image, [outline], isClosed=True, color=WANTED, thickness=2)
            self._keep(image, said)

    def take(self, jpeg: bytes, said: str) -> None:
        """Keep a picture from outside; nothing where none came."""
        image = _decode(jpeg)
        if image is not None:
            self._keep(image, said)

    def _keep(self, image: Image, caption: str) -> None:
        self._captions.append(caption)
        stem = self._directory / f"{len(self._captions):02d}"
        cv2.imwrite(str(stem.with_suffix(".jpg")), image, [cv2.IMWRITE_JPEG_QUALITY, 90])
        stem.with_suffix(".txt").write_text(caption + "\n")


def outline_of(circle: Circle) -> npt.NDArray[np.int32]:
    """Return the outline (n, 2) of the accepted circle in the picture [px]."""
    angles = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)
    on_surface = ACCEPTED_M * np.column_stack([np.cos(angles), np.sin(angles)])
    pixels_from_metres = np.linalg.pinv(circle.metres_from_pixels)
    return np.asarray(
        np.rint(np.asarray(circle.centre) + on_surface @ pixels_from_metres.T), np.int32
    )


def make_strip(directory: Path, path: Path) -> None:
    """Join the pictures of a run, from left to right and in rows of four, each with its words.

    Of a long run the first and the last pictures are shown. Without pictures nothing is written.
    """
    pictures = sorted(directory.glob("[0-9][0-9].jpg"))
    if not pictures:
        return
    if len(pictures) > MOST_FRAMES:
        pictures = [*pictures[: MOST_FRAMES // 2], *pictures[-(MOST_FRAMES // 2) :]]
    frames = [_framed(picture) for picture in pictures]
    columns = min(4, len(frames))
    blank = np.full_like(frames[0], 255)
    frames += [blank] * (-len(frames) % columns)
    rows = [np.hstack(frames[i : i + columns]) for i in range(0, len(frames), columns)]
    path.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(path), np.vstack(rows), [cv2.IMWRITE_JPEG_QUALITY, 88])


def _framed(picture: Path) -> Image:
    """Return a picture in the size of the strip, with its caption over it."""
    width, height = FRAME_SIZE
    result = np.full((height + CAPTION_HEIGHT + 6, width + 6, 3), 255, np.uint8)
    image = cv2.imread(str(picture))
    if image is not None:
        scale = min(width / image.shape[1], height / image.shape[0])
        size = round(image.shape[1] * scale), round(image.shape[0] * scale)
        small = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
        left = 3 + (width - size[0]) // 2
        result[CAPTION_HEIGHT : CAPTION_HEIGHT + size[1], left : left + size[0]] = small
    caption = picture.with_suffix(".txt").read_text().strip()
    fit = 0.52
    (text_width, _), _ = cv2.getTextSize(caption, FONT, fit, 1)
    fit *= min(1.0, (width - 8) / max(1, text_width))
    cv2.putText(result, caption, (6, CAPTION_HEIGHT - 11), FONT, fit, (30, 30, 30), 1, cv2.LINE_AA)
    return result


def _decode(jpeg: bytes) -> Image | None:
    if not jpeg:
        return None
    image = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
    return None if image is None else np.asarray(image, np.uint8)
