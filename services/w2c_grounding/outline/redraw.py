"""A heatmap whose regions end where things do. Pure functions."""

from collections.abc import Sequence

import cv2
import numpy as np
import numpy.typing as npt

from w2c_grounding.evidence import Mask, Region
from w2c_grounding.family import Heatmap
from w2c_grounding.outline.window import Window

BESIDE = 0.9
"""Heat of what is not the thing, at most, over that at which things end"""
WITHIN = 1.05
"""Heat of what is, at least, over that"""
LEAST_COMMON = 0.3
"""Of a region: a drawing with less of it is of something else, and is not used"""


def redrawn(
    heatmap: Heatmap,
    regions: Sequence[Region],
    windows: Sequence[Window],
    logits: npt.NDArray[np.float32],
    edge: float,
) -> tuple[Heatmap, list[Region]]:
    """Return a heatmap in which each region ends where the thing was drawn to end, and the regions.

    A region stays one, keeps its peak, and does not grow into another. Inside it the heat keeps its
    shape.

    Args:
        heatmap: (height, width).
        regions: Of it.
        windows: Around them.
        logits: (n, SIDE, SIDE) that there is the thing.
        edge: Share of the peak at which a thing ends.
    """
    level = edge * float(heatmap.max())
    taken = np.zeros(heatmap.shape, np.uint8)
    for number, region in enumerate(regions, start=1):
        taken[region.top : region.bottom, region.left : region.right][region.mask] = number
    result = heatmap.copy()
    new = list(regions)
    for number, (region, window, drawn) in enumerate(
        zip(regions, windows, logits, strict=True), start=1
    ):
        place, laid = window.onto_map(drawn, *heatmap.shape)
        owners = taken[place]
        others = cv2.dilate(((owners > 0) & (owners != number)).astype(np.uint8), np.ones((5, 5)))
        whole = _one_piece((laid > 0.0) & (others == 0), owners == number)
        if np.count_nonzero(whole & (owners == number)) < LEAST_COMMON * region.mask.sum():
            continue
        heat = result[place]
        hottest = float(heat[whole].max())
        inside = np.maximum(heat * np.float32(region.score / hottest), np.float32(WITHIN * level))
        faded = np.minimum(heat, np.float32(BESIDE * level))
        result[place] = np.where(
            whole, np.minimum(inside, region.score), np.where(owners == number, faded, heat)
        )
        owners[whole] = number
        new[number - 1] = _region(whole, place, region.score)
    return result, new


def _region(mask: Mask, place: tuple[slice, slice], score: float) -> Region:
    """Return the region of a mask that lies at a place of the heatmap."""
    left, top, width, height = cv2.boundingRect(mask.astype(np.uint8))
    u, v = place[1].start + left, place[0].start + top
    inside = mask[top : top + height, left : left + width]
    return Region(u, v, u + width, v + height, score, inside)


def _one_piece(drawn: Mask, region: Mask) -> Mask:
    """Return the connected piece of a drawing that has the most of a region in it."""
    count, labels = cv2.connectedComponents(drawn.astype(np.uint8), connectivity=8)
    common = np.bincount(labels[region & drawn], minlength=count)
    common[0] = 0
    return np.asarray((labels == common.argmax()) & drawn, np.bool_)
