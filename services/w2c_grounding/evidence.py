"""From what a model saw to an answer: found or not, where, how sure, and which point to touch.

Pure functions. Pixels are (u right, v down), the centre of pixel (0, 0) is at (0.5, 0.5).
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Literal

import cv2
import numpy as np
import numpy.typing as npt

from w2c.errors import ModelError
from w2c_grounding.boxes import distinct, usable, window
from w2c_grounding.family import Heatmap, ScoredBox

Mask = npt.NDArray[np.bool_]
Pixel = tuple[float, float]
PointRule = Literal["interior", "peak"]

REGION_FRACTION = 0.5
"""The region of a phrase is where the heat is at least this share of its peak. Half: the contour
that is usual for the extent of a peak, and it moves little when a model is more or less sure of
all its pixels."""
MIDDLE = 0.25
"""How far from the middle of a region its point may be drawn by heat, over the side of a square of
its area. On fresh scenes the point is then 0.09 of that side off the middle of the thing (median),
without it 0.16, and on the thing as often"""
_OVERFLOW = "half precision overflows in some models: try --dtype float32"


@dataclass(frozen=True)
class Region:
    """One connected piece of the picture that fits the phrase."""

    left: int
    top: int
    right: int
    bottom: int
    """(left, top) inclusive, (right, bottom) exclusive [px]"""
    score: float
    """Highest probability inside, or that of the model's own box"""
    mask: Mask
    """(bottom - top, right - left)"""

    def moved(self, du: int, dv: int) -> "Region":
        """Return the same region somewhere else [px]."""
        return replace(
            self,
            left=self.left + du,
            top=self.top + dv,
            right=self.right + du,
            bottom=self.bottom + dv,
        )


@dataclass(frozen=True)
class Finding:
    """The answer to one phrase."""

    found: bool
    score: float
    """Highest probability in the picture, also where nothing was found"""
    regions: tuple[Region, ...]
    """Best first, one for each thing that fits; empty where nothing was found"""
    point: Pixel | None
    """Where to touch it; None where nothing was found"""
    dropped_boxes: int = 0
    """How many boxes of the model made no sense"""


def logit(probability: float, largest: float) -> float:
    """Return the logarithm of the odds of a probability, not beyond a bound on either side."""
    least = 1.0 / (1.0 + math.exp(largest))
    bounded = min(max(probability, least), 1.0 - least)
    return math.log(bounded / (1.0 - bounded))


def logistic(logits: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Return the probabilities of logits."""
    # Beyond 60 the logistic function is 0 or 1 to the last bit; the bound keeps exp from
    # overflowing.
    bounded = np.clip(logits.astype(np.float32), -60.0, 60.0)
    return np.asarray(1.0 / (1.0 + np.exp(-bounded)), np.float32)


def heatmap_from_logits(logits: npt.NDArray[np.float32], width: int, height: int) -> Heatmap:
    """Return the probabilities of logits (h, w) that cover the whole picture, at its size.

    The logistic function comes before the scaling, so that a value between two pixels is a
    probability between theirs.
    """
    return heatmap_from_probabilities(logistic(logits), width, height)


def heatmap_from_probabilities(
    probabilities: npt.NDArray[np.float32], width: int, height: int
) -> Heatmap:
    """Return probabilities (h, w) that cover the whole picture, at its size."""
    coarse = np.ascontiguousarray(probabilities, dtype=np.float32)
    scaled = cv2.resize(coarse, (width, height), interpolation=cv2.INTER_LINEAR)
    return np.asarray(scaled, dtype=np.float32)


def find(
    heatmap: Heatmap,
    threshold: float,
    rule: PointRule = "interior",
    boxes: Iterable[ScoredBox] | None = None,
    edge: float = REGION_FRACTION,
) -> Finding:
    """Turn the evidence for a phrase into an answer.

    A model's own boxes, where it has them, say what was found and how sure; the heatmap then only
    says which of their pixels. Without boxes the connected regions of the heatmap do both.

    Args:
        heatmap: (height, width), 0 to 1.
        threshold: A score below it means: the picture does not show this.
        rule: How the point is chosen, see `interior_point` and `peak_point`.
        boxes: As the model gave them; None = it gives none. See `boxes.usable` for what is dropped.
        edge: Share of the peak at which a thing ends in a heatmap of this model.

    Raises:
        ModelError: the heatmap holds a value that is not finite, or no box has a score that is.
    """
    peak = float(heatmap.max())
    if not np.isfinite(peak):
        raise ModelError(f"the model answered with a heat of {peak}; {_OVERFLOW}")
    if boxes is None:
        score, dropped = peak, 0
        regions = regions_of(heatmap, threshold, edge) if score >= threshold else ()
    else:
        height, width = heatmap.shape
        given = tuple(boxes)
        if given and not any(math.isfinite(box.score) for box in given):
            raise ModelError(
                f"none of the {len(given)} boxes of the model has a score that is a number; "
                f"{_OVERFLOW}"
            )
        sound, dropped = usable(given, width, height)
        score = sound[0].score if sound else 0.0
        chosen = distinct([box for box in sound if box.score >= threshold])
        regions = tuple(region_of_box(heatmap, box) for box in chosen)
    if not regions:
        return Finding(False, score, (), None, dropped)
    if rule == "interior":
        point = interior_point(heatmap, regions[0])
    else:
        point = peak_point(heatmap) if boxes is None else peak_point(heatmap, regions[0])
    return Finding(True, score, regions, point, dropped)


def region_of_box(heatmap: Heatmap, box: ScoredBox) -> Region:
    """Return the part of a usable box that is hot: at least `REGION_FRACTION` of its peak.

    A box without any heat is taken whole.
    """
    height, width = heatmap.shape
    left, top, right, bottom = window(box, width, height)
    heat = heatmap[top:bottom, left:right]
    mask: Mask = heat >= REGION_FRACTION * float(heat.max())
    return Region(left, top, right, bottom, box.score, mask)


def regions_of(
    heatmap: Heatmap, threshold: float, edge: float = REGION_FRACTION
) -> tuple[Region, ...]:
    """Return the connected regions whose own peak reaches the threshold, the highest peak first.

    Regions are eight-connected sets of pixels with at least the share `edge` of the picture's peak.
    Equal peaks: the larger region comes first.
    """
    level = edge * float(heatmap.max())
    everywhere = heatmap >= level
    window = window_of(everywhere)
    if window is None:
        return ()
    first_row, first_column = window[0].start, window[1].start
    inside = everywhere[window].astype(np.uint8)
    _, labels, statistics, _ = cv2.connectedComponentsWithStats(inside, connectivity=8)
    regions: list[tuple[float, int, Region]] = []
    for label in range(1, len(statistics)):
        left, top, width, height, area = (int(value) for value in statistics[label])
        mask: Mask = labels[top : top + height, left : left + width] == label
        left, top = first_column + left, first_row + top
        peak = float(heatmap[top : top + height, left : left + width][mask].max())
        if peak >= threshold:
            region = Region(left, top, left + width, top + height, peak, mask)
            regions.append((peak, area, region))
    regions.sort(key=lambda entry: (-entry[0], -entry[1]))
    return tuple(region for _, _, region in regions)


def window_of(mask: Mask) -> tuple[slice, slice] | None:
    """Return the rows and columns of what is in a mask (h, w); None: nothing is.

    Most of a picture is cold, and what finds connected sets goes through all that it is given.
    """
    rows, columns = (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
    if not len(rows):
        return None
    return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)


def peak_point(heatmap: Heatmap, region: Region | None = None) -> Pixel:
    """Return the centre of the hottest pixel, of the picture or of a region's box.

    The arg-max of the paper, section Methods.
    """
    left, top = (0, 0) if region is None else (region.left, region.top)
    heat = heatmap if region is None else heatmap[top : region.bottom, left : region.right]
    v, u = np.unravel_index(int(heat.argmax()), heat.shape)
    return float(left + u) + 0.5, float(top + v) + 0.5


def interior_point(heatmap: Heatmap, region: Region) -> Pixel:
    """Return the pixel of a region that is hot, far from the region's edge, and near its middle.

    It maximises heat^2 * distance to the edge * exp(-r^2 / 2 s^2), in the part around the peak that
    has at least `REGION_FRACTION` of its heat; r is the distance from the centroid of the region's
    heat, s the share `MIDDLE` of the side of a square of its area. The arg-max alone often lies at
    a rim, where a hand that lands a centimetre off misses the object. The picture's border counts
    as an edge. Where nothing is hot (a model's box that its heatmap does not show) there is no heat
    to weigh with. Of equally good pixels the one nearest to their mean.
    """
    heat = heatmap[region.top : region.bottom, region.left : region.right]
    peak = float(heat[region.mask].max())
    hot = heat / np.float32(peak) if peak > 0.0 else np.ones_like(heat)
    weights = np.where(region.mask, hot, np.float32(0.0))
    padded = np.pad(_around_peak(weights), 1)
    distance = cv2.distanceTransform(padded, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)[1:-1, 1:-1]
    down, across = (
        np.square(np.arange(len(sums), dtype=np.float32) - _mean_index(sums))
        for sums in (weights.sum(axis=1), weights.sum(axis=0))
    )
    away = down[:, np.newaxis] + across
    # As logarithms: far from the middle of a long thin region the product would be zero everywhere.
    spread = 2.0 * MIDDLE**2 * np.count_nonzero(region.mask)
    with np.errstate(divide="ignore"):
        worth = np.log(np.square(hot) * distance) - away / spread
    best = np.argwhere(worth == worth.max())  # (n, 2), (v, u)
    v, u = best[np.square(best - best.mean(axis=0)).sum(axis=1).argmin()]
    return float(region.left + u) + 0.5, float(region.top + v) + 0.5


def _mean_index(weights: npt.NDArray[np.float32]) -> np.float32:
    return np.float32(np.average(np.arange(len(weights)), weights=weights))


def _around_peak(heat: Heatmap) -> npt.NDArray[np.uint8]:
    """Return 1 in the connected part with the peak in it and at least half of its heat, else 0."""
    hot = (heat >= REGION_FRACTION * heat.max()).astype(np.uint8)
    _, labels = cv2.connectedComponents(hot, connectivity=8)
    peak = np.unravel_index(int(heat.argmax()), heat.shape)
    return np.asarray(labels == labels[peak], dtype=np.uint8)


def thumbnail(heatmap: Heatmap, longest_side: int = 320) -> npt.NDArray[np.uint8]:
    """Return the heatmap as bytes, 255 = certain, its longest side bounded [px]: for the bus."""
    height, width = heatmap.shape
    scale = min(1.0, longest_side / max(height, width))
    size = (max(1, round(width * scale)), max(1, round(height * scale)))
    small = cv2.resize(heatmap, size, interpolation=cv2.INTER_AREA)
    return np.asarray(np.clip(np.rint(small * 255.0), 0, 255), dtype=np.uint8)
