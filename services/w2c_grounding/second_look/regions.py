"""Which regions of a heatmap are worth a look from near."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from w2c_grounding.boxes import area
from w2c_grounding.evidence import REGION_FRACTION, Region, regions_of
from w2c_grounding.family import Heatmap

FAINTEST = 0.05
"""Heat of a region that is worth a second look"""
LEAST_AREA = 0.0004
"""Of the picture: a smaller faint region is none of a thing"""
LEAST_BOX = 0.0002
"""Of the picture: a clear region in a smaller box is a speck, unless it is the hottest of all. Two
in five are, and cost as much to look at as others; without them as many of 4,172 phrases hit"""
STEP = 4
"""What is faint is looked for in every such pixel: a heatmap is smooth, and this runs for each
phrase"""
MOST_REGIONS = 8
"""Of a phrase that are looked at, the hottest ones"""


def worth_a_look(heatmap: Heatmap, edge: float = REGION_FRACTION) -> tuple[Region, ...]:
    """Return the regions to look at, the hottest first, at most `MOST_REGIONS`.

    Those of the heatmap that are no specks, and behind them what is fainter than their edge: of two
    of a kind the family is often sure of one alone.
    """
    peak = float(heatmap.max())
    level = edge * peak
    least_box = LEAST_BOX * heatmap.size
    clear_from = max(level, FAINTEST)
    coarse = heatmap[::STEP, ::STEP]
    least_area = LEAST_AREA * coarse.size
    lit = (coarse >= min(level, FAINTEST)).astype(np.uint8)
    _, labels, statistics, _ = cv2.connectedComponentsWithStats(lit, connectivity=8)
    clear: list[Region] = []
    faint: list[Region] = []
    for label in range(1, len(statistics)):
        left, top, width, height, cells = (int(value) for value in statistics[label])
        window = _Window.around(left, top, width, height)
        if window.pixels < least_box:
            needed = max(peak, FAINTEST)
        elif cells < least_area:
            needed = clear_from
        else:
            needed = FAINTEST
        # Where nothing fits, a hundred pieces are lit, and none is warm enough to be cut out.
        if window.of(heatmap).max() < needed:
            continue
        piece = _Piece(heatmap, labels[window.rows, window.columns] == label, window)
        hottest = float(piece.heat.max())
        if hottest >= clear_from:
            clear += piece.regions(level / hottest)
        elif hottest >= needed:
            faint += piece.regions(edge)[:1]
    clear = _hottest_first(clear)
    things = [*clear[:1], *(one for one in clear[1:] if area(one) >= least_box)]
    return (*things, *_hottest_first(faint))[:MOST_REGIONS]


def _hottest_first(regions: Sequence[Region]) -> list[Region]:
    return sorted(regions, key=lambda region: -region.score)


@dataclass(frozen=True)
class _Window:
    """A part of the picture that begins with every `STEP`-th row and column."""

    rows: slice
    columns: slice
    """Both in every `STEP`-th pixel"""

    @classmethod
    def around(cls, left: int, top: int, width: int, height: int) -> "_Window":
        """Return one more all around a box: its edge lies between two of those pixels."""
        return cls(
            slice(max(top - 1, 0), top + height + 1), slice(max(left - 1, 0), left + width + 1)
        )

    @property
    def top(self) -> int:
        """Return the first row [px]."""
        return STEP * int(self.rows.start)

    @property
    def left(self) -> int:
        """Return the first column [px]."""
        return STEP * int(self.columns.start)

    @property
    def pixels(self) -> int:
        """Return how many pixels it has."""
        rows = int(self.rows.stop) - int(self.rows.start)
        return STEP * STEP * rows * (int(self.columns.stop) - int(self.columns.start))

    def of(self, heatmap: Heatmap) -> Heatmap:
        """Return this part of a heatmap."""
        return heatmap[self.top : STEP * self.rows.stop, self.left : STEP * self.columns.stop]


class _Piece:
    """A connected piece of a heatmap, alone in its window."""

    def __init__(self, heatmap: Heatmap, inside: npt.NDArray[np.bool_], window: _Window) -> None:
        """Cut it out.

        Args:
            heatmap: (height, width).
            inside: Which of every `STEP`-th pixel of the window belong to it.
            window: Around them.
        """
        wider = cv2.dilate(inside.astype(np.uint8), np.ones((3, 3), np.uint8))
        self._left, self._top = window.left, window.top
        heat = window.of(heatmap)
        self._inside = _grown(inside, heat.shape)
        self.heat: Heatmap = heat * _grown(wider, heat.shape)

    def regions(self, edge: float) -> list[Region]:
        """Return its regions in the picture, the hottest first."""
        return [
            one.moved(self._left, self._top)
            for one in regions_of(self.heat, FAINTEST, edge)
            # Not the rim of a neighbour.
            if self._inside[one.top : one.bottom, one.left : one.right][one.mask].any()
        ]


def _grown(cells: npt.NDArray[Any], shape: tuple[int, ...]) -> npt.NDArray[Any]:
    return cells.repeat(STEP, axis=0).repeat(STEP, axis=1)[: shape[0], : shape[1]]
