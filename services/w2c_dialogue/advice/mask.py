"""Heatmaps times where a hand may go: which points are left, and why the others are not.

The paper's future work: the arg-max of a heatmap only where it is flat, large enough, not too
steep, and nothing that must not be touched. Pure functions on grids that cover a whole picture.
"""

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from w2c.messages import AllowedArea, PhraseEvidence

Grid = npt.NDArray[np.uint8]
Heat = npt.NDArray[np.float32]
Pixel = tuple[float, float]

REGION_SHARE = 0.5
"""What was asked for is where its heat is at least this share of its peak: as grounding has it"""
SPACING = 0.15
"""Between two candidate points, as a share of the size of what was asked for"""
VETO = "on the veto list"


@dataclass(frozen=True)
class Candidate:
    """A point that the mask allows."""

    pixel: Pixel
    weight: float
    """Heat times distance to what is not allowed, the best first"""


def resampled(grid: Grid, rows: int, columns: int) -> Grid:
    """Return a grid of codes at another size: the code at the middle of each new cell."""
    row = ((np.arange(rows) + 0.5) * grid.shape[0] / rows).astype(int)
    column = ((np.arange(columns) + 0.5) * grid.shape[1] / columns).astype(int)
    return np.asarray(grid[row[:, None], column])


def with_veto(
    area: AllowedArea, vetoed: list[PhraseEvidence], share: float, margin: float
) -> AllowedArea:
    """Return an area without the places where the picture shows what must not be touched.

    Args:
        area: What the surface allows.
        vetoed: Evidence for the no-go phrases that the model knows.
        share: Of a phrase's highest heat, from which on it is at a place.
        margin: Around such places [px of the picture].
    """
    found = [seen for seen in vetoed if seen.found]
    if not found:
        return area
    rows, columns = area.cells.shape
    there = np.zeros((rows, columns), np.uint8)
    for seen in found:
        there |= _presence(seen, area, share)
    radius = max(1, round(margin * columns / area.width))
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * radius + 1, 2 * radius + 1))
    near = cv2.dilate(there, disc).astype(bool)
    cells = np.where(near, len(area.reasons) + 1, area.cells).astype(np.uint8)
    return AllowedArea(
        stamp_ns=area.stamp_ns,
        width=area.width,
        height=area.height,
        cells=cells,
        reasons=[*area.reasons, VETO],
    )


def candidates(seen: PhraseEvidence, area: AllowedArea, count: int) -> list[Candidate]:
    """Return where on a thing a hand may go, best first; empty where nothing is allowed.

    The rule is that of grounding, hot and far from the edge, with the border of the allowed area
    as an edge: a hand that lands a little off stays inside. Each point keeps its distance from the
    ones before, so that a few of them cover the thing.
    """
    heat, region = _region(seen, area)
    rows, columns = heat.shape
    allowed = region & (resampled(area.cells, rows, columns) == 0)
    if not allowed.any():
        return []
    padded = np.pad(allowed.astype(np.uint8), 1)
    distance = cv2.distanceTransform(padded, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)[1:-1, 1:-1]
    weight = heat * distance
    spacing = max(1.0, SPACING * float(np.sqrt(region.sum())))
    v, u = np.mgrid[0:rows, 0:columns]
    found: list[Candidate] = []
    while len(found) < count and weight.max() > 0.0:
        row, column = np.unravel_index(int(weight.argmax()), weight.shape)
        pixel = ((column + 0.5) * area.width / columns, (row + 0.5) * area.height / rows)
        found.append(Candidate((float(pixel[0]), float(pixel[1])), float(weight[row, column])))
        weight = np.where(np.hypot(u - column, v - row) < spacing, 0.0, weight)
    return found


def why_not(seen: PhraseEvidence, area: AllowedArea) -> str:
    """Return what forbids a thing, the most frequent first: `too steep (80 %), no depth (20 %)`."""
    heat, region = _region(seen, area)
    codes = resampled(area.cells, *heat.shape)[region]
    counts = np.bincount(codes, minlength=len(area.reasons) + 1)[1:]
    order = [int(code) for code in np.argsort(-counts, kind="stable") if counts[code] > 0]
    return ", ".join(f"{area.reasons[i]} ({counts[i] / len(codes):.0%})" for i in order)


def _region(seen: PhraseEvidence, area: AllowedArea) -> tuple[Heat, npt.NDArray[np.bool_]]:
    """Return the heat (rows, columns) of a thing, and where it is."""
    if seen.heatmap is not None:
        heat = seen.heatmap.astype(np.float32) / 255.0
    else:
        heat = _boxes(seen, area).astype(np.float32) * np.float32(seen.score)
    return heat, heat >= max(REGION_SHARE * float(heat.max()), 1e-6)


def _presence(seen: PhraseEvidence, area: AllowedArea, share: float) -> Grid:
    """Return 1 in the cells of an area where the picture shows a phrase."""
    if seen.heatmap is None:
        return _boxes(seen, area)
    rows, columns = area.cells.shape
    # The hottest of the pixels that a cell covers: a mean would lose what is small.
    hot = (seen.heatmap >= 255.0 * share * seen.score).astype(np.uint8)
    fine = resampled(hot, max(rows, hot.shape[0]), max(columns, hot.shape[1]))
    presence = np.zeros((rows, columns), np.uint8)
    v, u = np.nonzero(fine)
    presence[v * rows // fine.shape[0], u * columns // fine.shape[1]] = 1
    return presence


def _boxes(seen: PhraseEvidence, area: AllowedArea) -> Grid:
    """Return 1 in the cells of an area that the boxes of a phrase touch."""
    rows, columns = area.cells.shape
    grid = np.zeros((rows, columns), np.uint8)
    for box in seen.boxes:
        top, bottom = box.top * rows / area.height, box.bottom * rows / area.height
        left, right = box.left * columns / area.width, box.right * columns / area.width
        grid[
            max(0, int(top)) : max(0, int(np.ceil(bottom))),
            max(0, int(left)) : max(0, int(np.ceil(right))),
        ] = 1
    return grid
