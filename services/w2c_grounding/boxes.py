"""Boxes as models give them become boxes to rely on. Pure functions.

Pixels are (u right, v down), the centre of pixel (0, 0) is at (0.5, 0.5).
"""

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from w2c_grounding.family import ScoredBox

if TYPE_CHECKING:
    from w2c_grounding.evidence import Region

MAX_BOXES = 50
"""The best of a phrase that are looked at. A detector may answer with thousands of weak ones."""

DUPLICATE_OVERLAP = 0.6
"""Two boxes with a higher intersection over union show the same thing. Detectors without
suppression of their own give several boxes a thing; two things of a kind, even touching, stay
below."""


def usable(
    boxes: Iterable[ScoredBox], width: int, height: int
) -> tuple[tuple[ScoredBox, ...], int]:
    """Return the boxes that can be relied on, clipped to the picture, and how many were dropped.

    Dropped are boxes with a number that is not finite, inverted ones, and those that are empty or
    wholly outside. Scores are clipped to [0, 1]. Best first; equal scores: the larger box first.

    Args:
        boxes: In pixels of the picture.
        width: Of the picture [px].
        height: Of the picture [px].
    """
    kept: list[ScoredBox] = []
    dropped = 0
    for box in boxes:
        left, top = max(0.0, float(box.left)), max(0.0, float(box.top))
        right, bottom = min(float(width), float(box.right)), min(float(height), float(box.bottom))
        # `max` and `min` above hide a NaN, so that the original numbers are asked.
        if all(math.isfinite(value) for value in box) and left < right and top < bottom:
            score = min(1.0, max(0.0, float(box.score)))
            kept.append(ScoredBox(left, top, right, bottom, score))
        else:
            dropped += 1
    kept.sort(key=lambda box: (-box.score, -area(box)))
    return tuple(kept), dropped


def distinct(
    boxes: Sequence[ScoredBox], overlap: float = DUPLICATE_OVERLAP
) -> tuple[ScoredBox, ...]:
    """Return the boxes without those that show a thing a better one shows already.

    Greedy suppression: `boxes` come best first, and at most `MAX_BOXES` of them are looked at.
    """
    kept: list[ScoredBox] = []
    for box in boxes[:MAX_BOXES]:
        if all(intersection_over_union(box, other) <= overlap for other in kept):
            kept.append(box)
    return tuple(kept)


def area(box: "ScoredBox | Region") -> float:
    """Return the area [px^2] of a box that is not inverted, or of the one around a region."""
    return (box.right - box.left) * (box.bottom - box.top)


def intersection_over_union(first: ScoredBox, second: ScoredBox) -> float:
    """Return the common area over the joint area, 0 to 1. Neither box is empty."""
    width = min(first.right, second.right) - max(first.left, second.left)
    height = min(first.bottom, second.bottom) - max(first.top, second.top)
    common = max(0.0, width) * max(0.0, height)
    return common / (area(first) + area(second) - common)


def window(box: ScoredBox, width: int, height: int) -> tuple[int, int, int, int]:
    """Return (left, top, right, bottom) of the pixels whose centre lies in a usable box.

    At least one pixel: a box thinner than a pixel gets the one that holds its centre.
    """
    left, right = _span(box.left, box.right, width)
    top, bottom = _span(box.top, box.bottom, height)
    return left, top, right, bottom


def _span(low: float, high: float, size: int) -> tuple[int, int]:
    first, last = int(np.ceil(low - 0.5)), int(np.ceil(high - 0.5))
    if last <= first:
        first = min(size - 1, int((low + high) / 2))
        last = first + 1
    return first, last
