"""Pictures for people: the accepted area over the picture, the prompt below, and contact sheets."""

from collections.abc import Sequence

import cv2
import numpy as np
import numpy.typing as npt

from w2c.errors import ConfigError

Picture = npt.NDArray[np.uint8]
"""(h, w, 3) in the order of OpenCV: blue, green, red"""
Mask = npt.NDArray[np.bool_]
YELLOW = (40, 220, 250)
GREEN, RED, WHITE, BLACK = (60, 200, 60), (50, 50, 230), (255, 255, 255), (0, 0, 0)
LINE_HEIGHT = 22
MARGIN = 8
GAP = 6


def tinted(picture: Picture, mask: Mask) -> Picture:
    """Return a picture with an area in yellow, as in the paper's figures, and its outline."""
    result = picture.copy()
    tint = 0.55 * picture[mask].astype(np.float32) + 0.45 * np.array(YELLOW, np.float32)
    result[mask] = tint.astype(np.uint8)
    outlines, _ = cv2.findContours(
        mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE
    )
    cv2.drawContours(result, outlines, -1, YELLOW, max(1, picture.shape[1] // 640))
    return result


def with_point(picture: Picture, point: tuple[float, float], *, hit: bool) -> Picture:
    """Return a picture with a point on it, green for a hit, red for a miss."""
    result = picture.copy()
    at = round(point[0]), round(point[1])
    radius = max(4, picture.shape[1] // 110)
    cv2.circle(result, at, radius, WHITE, -1, cv2.LINE_AA)
    cv2.circle(result, at, max(2, radius - 3), GREEN if hit else RED, -1, cv2.LINE_AA)
    return result


def with_box(picture: Picture, edges: Sequence[float]) -> Picture:
    """Return a picture with a box of (left, top, right, bottom) on it."""
    result = picture.copy()
    left, top, right, bottom = (round(value) for value in edges)
    cv2.rectangle(result, (left, top), (right, bottom), WHITE, 2)
    return result


def captioned(picture: Picture, lines: Sequence[str], width: int = 640) -> Picture:
    """Return a picture of this width with lines of text below."""
    height = round(picture.shape[0] * width / picture.shape[1])
    small = cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA)
    letters = (width - 2 * MARGIN) // 9
    rows = [row for line in lines for row in _wrapped(line, letters)]
    below = np.full((LINE_HEIGHT * len(rows) + MARGIN, width, 3), 255, np.uint8)
    for number, row in enumerate(rows, 1):
        at = MARGIN, LINE_HEIGHT * number - 4
        cv2.putText(below, row, at, cv2.FONT_HERSHEY_SIMPLEX, 0.5, BLACK, 1, cv2.LINE_AA)
    return np.asarray(np.vstack([small, below]), dtype=np.uint8)


def sheet(pictures: Sequence[Picture], columns: int = 4) -> Picture:
    """Return pictures of one width beside and below each other."""
    if not pictures:
        raise ConfigError("a sheet of no pictures")
    width = pictures[0].shape[1]
    rows = []
    for first in range(0, len(pictures), columns):
        row = pictures[first : first + columns]
        height = max(picture.shape[0] for picture in row)
        cells = np.full((height + GAP, columns * (width + GAP), 3), 255, np.uint8)
        for number, picture in enumerate(row):
            left = number * (width + GAP)
            cells[: picture.shape[0], left : left + width] = picture
        rows.append(cells)
    return np.asarray(np.vstack(rows), dtype=np.uint8)


def encoded(suffix: str, picture: npt.NDArray[np.uint8], quality: int = 95) -> bytes:
    """Return the bytes of a file of a picture."""
    options = [cv2.IMWRITE_JPEG_QUALITY, quality] if suffix == ".jpg" else []
    done, data = cv2.imencode(suffix, picture, options)
    if not done:
        raise ConfigError(f"no {suffix} of a picture of shape {picture.shape}")
    return bytes(data.tobytes())


def _wrapped(text: str, letters: int) -> list[str]:
    rows = [""]
    for word in text.split():
        longer = f"{rows[-1]} {word}".strip()
        if len(longer) <= letters or not rows[-1]:
            rows[-1] = longer
        else:
            rows.append(word)
    return rows
