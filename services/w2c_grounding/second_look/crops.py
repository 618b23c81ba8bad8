"""Cuts a square around a thing out of a picture."""

from collections.abc import Sequence

import cv2
import numpy as np

from w2c_grounding.family import RgbImage

PICTURE_WIDTH = 1280
"""Pictures are brought to it first [px]: those of the training had it, and a small thing must not
look sharper than it did there"""
SIDE = 80
"""Of what the network reads [px]"""
MARGIN = 0.15
"""Around the longer side of a box, both ends together, as a share of it"""
LEAST = 20.0
"""Of the side that is cut out [px of the picture]"""
GREY = (127, 127, 127)
"""Beyond the border of the picture"""


def brought_to_width(image: RgbImage) -> tuple[RgbImage, float]:
    """Return the picture `PICTURE_WIDTH` wide, and the factor by which its pixels were scaled."""
    scale = PICTURE_WIDTH / image.shape[1]
    size = (PICTURE_WIDTH, max(1, round(image.shape[0] * scale)))
    method = cv2.INTER_AREA if scale < 1.0 else cv2.INTER_LINEAR
    return np.asarray(cv2.resize(image, size, interpolation=method), np.uint8), scale


def square_around(
    image: RgbImage, box: Sequence[float], side: int = SIDE, margin: float = MARGIN
) -> RgbImage:
    """Return the square (side, side, 3) around a box, whose aspect is kept.

    Args:
        image: (height, width, 3).
        box: Left, top, right, bottom [px]; it has a part in the picture.
        side: Of the result [px].
        margin: See `MARGIN`.
    """
    left, top, right, bottom = box
    length = max((1.0 + margin) * max(right - left, bottom - top), LEAST)
    first_u = round(0.5 * (left + right - length))
    first_v = round(0.5 * (top + bottom - length))
    whole = max(1, round(length))
    height, width = image.shape[:2]
    inside = image[
        max(first_v, 0) : min(first_v + whole, height),
        max(first_u, 0) : min(first_u + whole, width),
    ]
    square = cv2.copyMakeBorder(
        inside,
        max(-first_v, 0),
        max(first_v + whole - height, 0),
        max(-first_u, 0),
        max(first_u + whole - width, 0),
        cv2.BORDER_CONSTANT,
        value=GREY,
    )
    method = cv2.INTER_AREA if whole > side else cv2.INTER_LINEAR
    return np.asarray(cv2.resize(square, (side, side), interpolation=method), np.uint8)
