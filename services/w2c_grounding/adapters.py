"""Boxes, masks, polygons and points as heatmaps, so that any family fills any slot.

Pure functions; a family calls them with what its model answered. Pixels are (u right, v down), the
centre of pixel (0, 0) is at (0.5, 0.5). What is not finite, empty, or outside the picture is left
out. Where two things cover a pixel the more certain one counts. Nothing of the size of the picture
is held beside the result (float32) but a mask (one byte a pixel) where one has to be drawn.
"""

from collections.abc import Iterable, Sequence

import cv2
import numpy as np
import numpy.typing as npt

from w2c_grounding.boxes import usable, window
from w2c_grounding.evidence import REGION_FRACTION
from w2c_grounding.family import Heatmap, ScoredBox

AnyMask = npt.NDArray[np.bool_] | npt.NDArray[np.uint8] | npt.NDArray[np.floating]
"""(h, w), covers the whole picture at any resolution; bool, or uint8 with 0 = outside, or
probabilities from 0 to 1"""

Polygon = npt.NDArray[np.floating] | Sequence[tuple[float, float]]
"""(n, 2) corners (u, v) [px], n >= 3; the last is joined to the first"""

RIM = 0.95
"""Heat of a box at its rim, over that at its centre. Close to 1, since the box says nothing about
its inside; below 1, so that the arg-max is the centre and not a corner."""

_POINT_REACH = 3.0
"""A point warms up to this many of its radii: there the heat is 0.2 % of its peak."""

_FRACTION_BITS = 4
"""Of a polygon's corners when it is drawn: 1/16 px"""


def heatmap_from_boxes(boxes: Iterable[ScoredBox], width: int, height: int) -> Heatmap:
    """Return heat that is a box's score at its centre and `RIM` times that at its rim.

    The region of a box, as `evidence.regions_of` finds it, is the box.
    """
    heat = np.zeros((height, width), dtype=np.float32)
    for box in usable(boxes, width, height)[0]:
        left, top, right, bottom = window(box, width, height)
        _raise(heat[top:bottom, left:right], _cushion(right - left, bottom - top, box.score))
    return heat


def heatmap_from_masks(
    masks: Iterable[AnyMask], scores: Iterable[float], width: int, height: int
) -> Heatmap:
    """Return heat that is a mask's score, times its own probability where it has one.

    Args:
        masks: One a thing, each at any resolution.
        scores: One a mask, 0 to 1.
        width: Of the picture [px].
        height: Of the picture [px].
    """
    heat = np.zeros((height, width), dtype=np.float32)
    for mask, score in zip(masks, scores, strict=True):
        certain = _score(score)
        if certain is None or mask.size == 0:
            continue
        if np.issubdtype(mask.dtype, np.floating):
            _raise(heat, _soft_mask(mask, certain, width, height))
        else:
            np.maximum(heat, certain, out=heat, where=_full_size(mask, width, height))
    return heat


def heatmap_from_polygons(
    polygons: Iterable[Polygon], scores: Iterable[float], width: int, height: int
) -> Heatmap:
    """Return heat that is a polygon's score inside it.

    Args:
        polygons: One a piece; a thing of several pieces is several polygons.
        scores: One a polygon, 0 to 1.
        width: Of the picture [px].
        height: Of the picture [px].
    """
    heat = np.zeros((height, width), dtype=np.float32)
    canvas = np.zeros((height, width), dtype=np.uint8)
    for polygon, score in zip(polygons, scores, strict=True):
        certain = _score(score)
        corners = np.asarray(polygon, dtype=np.float64)
        if certain is None or corners.ndim != 2 or corners.shape[0] < 3 or corners.shape[1] != 2:
            continue
        if not np.isfinite(corners).all():
            continue
        # One picture outside is as good as far outside, and does not overflow the drawing.
        corners = np.clip(corners, (-width, -height), (2 * width, 2 * height))
        left, top = np.clip(np.floor(corners.min(axis=0)), 0, (width, height)).astype(int)
        right, bottom = np.clip(np.ceil(corners.max(axis=0)) + 1, 0, (width, height)).astype(int)
        drawn = canvas[top:bottom, left:right]
        if drawn.size == 0:
            continue
        # OpenCV calls the centre of its first pixel (0, 0).
        fixed = np.rint((corners - 0.5) * 2**_FRACTION_BITS).astype(np.int32)
        cv2.fillPoly(canvas, [fixed], 1, shift=_FRACTION_BITS)
        warm = heat[top:bottom, left:right]
        np.maximum(warm, certain, out=warm, where=drawn.astype(bool))
        drawn[:] = 0
    return heat


def heatmap_from_points(
    points: Iterable[tuple[float, float]],
    scores: Iterable[float],
    width: int,
    height: int,
    radius: float,
) -> Heatmap:
    """Return heat that is a point's score there and falls with the distance.

    score * REGION_FRACTION ** (distance / radius)^2: the region of a point, as
    `evidence.regions_of` finds it, is a disc of the radius, and the arg-max is the pixel that holds
    the point.

    Args:
        points: (u, v) [px]. One that lies outside the picture is left out, not moved to its border.
        scores: One a point, 0 to 1.
        width: Of the picture [px].
        height: Of the picture [px].
        radius: How far from the point the thing reaches, or how far the model errs [px], above 0.
    """
    heat = np.zeros((height, width), dtype=np.float32)
    reach = _POINT_REACH * radius
    for (u, v), score in zip(points, scores, strict=True):
        certain = _score(score)
        if certain is None or not (0.0 <= u < width and 0.0 <= v < height):
            continue
        # Distances count from the centre of the pixel that holds the point, so that its heat is
        # the score however small the radius is.
        column, row = int(u), int(v)
        left, right = max(0, int(column - reach)), min(width, int(column + reach) + 2)
        top, bottom = max(0, int(row - reach)), min(height, int(row + reach) + 2)
        across = np.square((np.arange(left, right, dtype=np.float32) - column) / radius)
        down = np.square((np.arange(top, bottom, dtype=np.float32) - row) / radius)
        _raise(heat[top:bottom, left:right], _bump(across, down, certain))
    return heat


def boxes_from_masks(
    masks: Iterable[AnyMask], scores: Iterable[float], width: int, height: int
) -> tuple[ScoredBox, ...]:
    """Return the tight box of each mask, in pixels of the picture; an empty mask has none.

    A probability of one half is the edge of a mask.

    Args:
        masks: One a thing, each at any resolution.
        scores: One a mask, 0 to 1.
        width: Of the picture [px].
        height: Of the picture [px].
    """
    boxes: list[ScoredBox] = []
    for mask, score in zip(masks, scores, strict=True):
        certain = _score(score)
        inside = mask >= 0.5 if np.issubdtype(mask.dtype, np.floating) else mask != 0
        columns = np.flatnonzero(inside.any(axis=0))
        rows = np.flatnonzero(inside.any(axis=1))
        if certain is None or columns.size == 0:
            continue
        across, down = width / mask.shape[1], height / mask.shape[0]
        boxes.append(
            ScoredBox(
                float(columns[0] * across),
                float(rows[0] * down),
                float((columns[-1] + 1) * across),
                float((rows[-1] + 1) * down),
                certain,
            )
        )
    return tuple(boxes)


# What follows returns a picture that is gone before the next is made.


def _cushion(width: int, height: int, score: float) -> Heatmap:
    """Return (height, width) that falls from the score in the middle to `RIM` of it at the edge."""
    across, down = _from_centre(width), _from_centre(height)
    heat = np.maximum(across[np.newaxis, :], down[:, np.newaxis])
    heat *= score * (RIM - 1.0)
    heat += score
    return heat


def _soft_mask(mask: AnyMask, score: float, width: int, height: int) -> Heatmap:
    """Return (height, width), the score times the mask's own probability."""
    heat = mask.astype(np.float32)
    np.nan_to_num(heat, copy=False, nan=0.0, posinf=1.0, neginf=0.0)
    np.clip(heat, 0.0, 1.0, out=heat)
    if heat.shape != (height, width):
        heat = np.asarray(cv2.resize(heat, (width, height)), dtype=np.float32)
    heat *= score
    return heat


def _bump(across: npt.NDArray[np.float32], down: npt.NDArray[np.float32], score: float) -> Heatmap:
    """Return (n, m) from the squared distances (m,) and (n,) in radii."""
    heat = across[np.newaxis, :] + down[:, np.newaxis]
    np.power(np.float32(REGION_FRACTION), heat, out=heat)
    heat *= score
    return heat


def _from_centre(size: int) -> npt.NDArray[np.float32]:
    """Return how far each of `size` pixels is from the middle one, 0 there, below 1 at the end."""
    distance = np.abs(np.arange(size, dtype=np.float32) + 0.5 - size / 2)
    distance -= distance.min()
    return np.asarray(distance / (size / 2), dtype=np.float32)


def _raise(heat: Heatmap, to: Heatmap) -> None:
    """Raise the heat where it is lower, in place."""
    np.maximum(heat, to, out=heat)


def _score(score: float) -> float | None:
    """Return the score within [0, 1]; None where it is no number."""
    return min(1.0, max(0.0, float(score))) if np.isfinite(score) else None


def _full_size(mask: AnyMask, width: int, height: int) -> npt.NDArray[np.bool_]:
    inside = mask if mask.dtype == np.bool_ else mask != 0
    if inside.shape == (height, width):
        return np.asarray(inside, dtype=np.bool_)
    small = np.ascontiguousarray(inside, dtype=np.uint8)
    return cv2.resize(small, (width, height), interpolation=cv2.INTER_NEAREST).view(np.bool_)
