"""An overlay drawn into the pixels of a picture."""

import cv2
import numpy as np
import numpy.typing as npt

from w2c.errors import RecordingError
from w2c.messages import Array
from w2c_recorder.overlay import Overlay, Pixel

BgrImage = npt.NDArray[np.uint8]

POINT_COLOUR = (255, 80, 0)
BOX_COLOUR = (0, 220, 255)
HEAT_COLOUR = (255, 0, 255)
"""Blue, green, red"""
TEXT_COLOUR = (255, 255, 255)
HEAT_OPACITY = 0.6
CIRCLE_RADIUS = 18
"""Of the target on the operator's page [px]"""


def decode_picture(jpeg: bytes) -> BgrImage:
    """Return the pixels (h, w, 3). Raises RecordingError for bytes that are no picture."""
    if not jpeg:
        raise RecordingError("the recorded picture has no bytes")
    image = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
    if image is None:
        raise RecordingError(f"the recorded picture of {len(jpeg)} bytes is no JPEG")
    return np.asarray(image, dtype=np.uint8)


def encode_picture(image: BgrImage, suffix: str) -> bytes:
    """Return the bytes of a file with this suffix (.png, .jpg)."""
    return bytes(cv2.imencode(suffix, image)[1].tobytes())


def draw(image: BgrImage, overlay: Overlay) -> BgrImage:
    """Return a copy of the picture with heat below, boxes above it, and the target on top."""
    canvas = _heated(image, overlay.heat)
    for box, label in overlay.boxes:
        first = (round(box.left), round(box.top))
        cv2.rectangle(canvas, first, (round(box.right) - 1, round(box.bottom) - 1), BOX_COLOUR, 2)
        _write(canvas, f"{label} {box.score:.2f}".strip(), (first[0], first[1] - 6), BOX_COLOUR)
    if overlay.point is not None:
        # (0.5, 0.5) is the centre of the first pixel; OpenCV counts centres from (0, 0).
        centre = (round(overlay.point[0] - 0.5), round(overlay.point[1] - 0.5))
        cv2.circle(canvas, centre, CIRCLE_RADIUS, (255, 255, 255), 4, cv2.LINE_AA)
        cv2.circle(canvas, centre, CIRCLE_RADIUS, POINT_COLOUR, 2, cv2.LINE_AA)
        cv2.circle(canvas, centre, 5, POINT_COLOUR, -1, cv2.LINE_AA)
        _write(canvas, overlay.label, (centre[0] + 24, centre[1] - 12), TEXT_COLOUR)
    return canvas


def caption(image: BgrImage, lines: list[str]) -> None:
    """Write lines into the upper left corner."""
    for row, line in enumerate(lines):
        _write(image, line, (10, 26 + 26 * row), TEXT_COLOUR)


def heat_png(heat: tuple[Array, ...]) -> bytes:
    """Return the heat as a PNG to be laid over its picture; no bytes where there is no heat."""
    if not heat:
        return b""
    first = heat[0]
    size = (first.shape[1], first.shape[0])
    hottest = np.max([cv2.resize(np.ascontiguousarray(one), size) for one in heat], axis=0)
    coloured = np.empty((*hottest.shape, 4), np.uint8)
    coloured[:, :, :3] = HEAT_COLOUR
    coloured[:, :, 3] = HEAT_OPACITY * hottest
    return encode_picture(coloured, ".png")


def _heated(image: BgrImage, heat: tuple[Array, ...]) -> BgrImage:
    if not heat:
        return image.copy()
    size = (image.shape[1], image.shape[0])
    hottest = np.max([cv2.resize(np.ascontiguousarray(one), size) for one in heat], axis=0)
    weight = (HEAT_OPACITY / 255.0) * hottest[:, :, np.newaxis].astype(np.float32)
    mixed = image * (1.0 - weight) + np.asarray(HEAT_COLOUR, np.float32) * weight
    return np.ascontiguousarray(np.clip(mixed, 0, 255).astype(np.uint8))


def _write(image: BgrImage, text: str, at: Pixel, colour: tuple[int, int, int]) -> None:
    plain = text.encode("ascii", "replace").decode()  # all that OpenCV's letters have
    (width, height), _ = cv2.getTextSize(plain, cv2.FONT_HERSHEY_SIMPLEX, 0.6, 1)
    # Inside the picture, dark below light: readable at any place and on any background.
    u = int(min(max(at[0], 4), max(4, image.shape[1] - width - 4)))
    v = int(min(max(at[1], height + 4), image.shape[0] - 4))
    # Not a thicker stroke below: some versions of OpenCV then set the letters wider.
    for right, down in ((-1, -1), (1, -1), (-1, 1), (1, 1), (0, 0)):
        ink = colour if right == 0 else (0, 0, 0)
        place = (u + right, v + down)
        cv2.putText(image, plain, place, cv2.FONT_HERSHEY_SIMPLEX, 0.6, ink, 1, cv2.LINE_AA)
