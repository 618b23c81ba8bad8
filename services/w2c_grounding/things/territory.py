"""Which pixels belong to which thing, and what a heatmap says of each. Pure functions.

Pixels are (u right, v down), the centre of pixel (0, 0) is at (0.5, 0.5).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from w2c_grounding.evidence import Mask, Region
from w2c_grounding.family import Heatmap
from w2c_grounding.things.proposals import Thing

Box = tuple[float, float, float, float]
"""Left, top, right, bottom [px]"""

FLOOR = 1.15
"""Heat of what belongs to a thing, at least, over that at which it ends"""
RIM = 0.008
"""Of the picture's width: heat so near to a thing is its glow, and no other thing's"""
_FAINTEST = 1e-6


@dataclass(frozen=True)
class Ground:
    """The part of a picture that one thing has."""

    left: int
    top: int
    mine: Mask
    """(height, width) of the box: what is not another's"""
    seen: Mask
    """And of that where it is seen, as far as one knows without a phrase"""

    @property
    def window(self) -> tuple[slice, slice]:
        """Return its rows and columns."""
        height, width = self.mine.shape
        return slice(self.top, self.top + height), slice(self.left, self.left + width)


@dataclass(frozen=True)
class Territory:
    """A picture divided among its things."""

    grounds: tuple[Ground, ...]
    """Of each thing of which anything is seen"""
    beside: Heatmap
    """(height, width) 0 where a pixel belongs to a thing, or is next to one, else 1"""

    @property
    def boxes(self) -> list[Box]:
        """Return left, top, right and bottom of each thing [px]."""
        return [
            (g.left, g.top, g.left + g.mine.shape[1], g.top + g.mine.shape[0]) for g in self.grounds
        ]


def divided(things: Sequence[Thing], height: int, width: int) -> Territory:
    """Return a picture of this size [px], divided.

    What several boxes hold belongs to the thing that is seen there; where none is, to the one with
    the smallest box. Between two things a line belongs to neither, so that they do not touch.
    """
    windows = [_window(thing, height, width) for thing in things]
    owners = np.zeros((height, width), np.uint8)
    shown = np.zeros((height, width), np.float32)
    by_size = sorted(range(len(things)), key=lambda n: -_size(windows[n]))
    # The smaller ones last: they lie on the larger ones.
    for number in by_size:
        owners[windows[number]] = number + 1
    for number in by_size:
        window = windows[number]
        laid = _laid(things[number].places, window, height, width)
        mine = laid > np.maximum(shown[window], 0.5)
        owners[window][mine] = number + 1
        shown[window][mine] = laid[mine]
    apart = _lines_between(owners)
    grounds = []
    for number, window in enumerate(windows):
        mine = (owners[window] == number + 1) & ~apart[window]
        seen = mine & (shown[window] > 0.0)
        if seen.any():
            grounds.append(Ground(window[1].start, window[0].start, mine, seen))
    reach = 2 * round(RIM * width) + 1
    taken = np.zeros((height, width), np.uint8)
    for ground in grounds:
        taken[ground.window][ground.seen] = 1
    near = cv2.dilate(taken, np.ones((reach, reach), np.uint8))
    return Territory(tuple(grounds), np.asarray(1 - near, np.float32))


def lit(heatmap: Heatmap, territory: Territory, edge: float) -> tuple[Heatmap, tuple[Region, ...]]:
    """Return a heatmap in which each thing is one region, and these regions.

    A thing is as hot as its hottest pixel. It is where it is seen, and where it is hot; heat that
    is lower there than at its end is raised a little above that.

    Args:
        heatmap: (height, width).
        territory: Of the picture.
        edge: Share of its peak at which a thing ends.
    """
    result = heatmap.copy()
    regions: list[Region] = []
    for ground in territory.grounds:
        heat = heatmap[ground.window]
        score = max(float(heat[ground.mine].max()), _FAINTEST)
        mask = ground.seen | (ground.mine & (heat >= edge * score))
        here = result[ground.window]
        here[mask] = np.maximum(heat[mask], np.float32(FLOOR * edge * score))
        height, width = mask.shape
        regions.append(
            Region(ground.left, ground.top, ground.left + width, ground.top + height, score, mask)
        )
    return result, tuple(regions)


def outside(heatmap: Heatmap, territory: Territory) -> Heatmap:
    """Return the heatmap where it is of no thing, and 0 elsewhere."""
    return heatmap * territory.beside


def _window(thing: Thing, height: int, width: int) -> tuple[slice, slice]:
    left, top, right, bottom = thing.box
    first_u = min(int(left * width), width - 1)
    first_v = min(int(top * height), height - 1)
    return (
        slice(first_v, max(first_v + 1, min(height, round(bottom * height)))),
        slice(first_u, max(first_u + 1, min(width, round(right * width)))),
    )


def _size(window: tuple[slice, slice]) -> int:
    return int((window[0].stop - window[0].start) * (window[1].stop - window[1].start))


def _laid(
    places: Mask, window: tuple[slice, slice], height: int, width: int
) -> npt.NDArray[np.float32]:
    """Return how much each pixel of a window is of some places (rows, columns), 0 to 1."""
    rows, columns = places.shape
    across, down = columns / width, rows / height
    move = np.array(
        [
            [across, 0.0, (window[1].start + 0.5) * across - 0.5],
            [0.0, down, (window[0].start + 0.5) * down - 0.5],
        ]
    )
    size = (window[1].stop - window[1].start, window[0].stop - window[0].start)
    laid = cv2.warpAffine(
        places.astype(np.float32),
        move,
        size,
        flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
        borderMode=cv2.BORDER_REPLICATE,
    )
    return np.asarray(laid, np.float32)


def _lines_between(owners: npt.NDArray[np.uint8]) -> Mask:
    """Return which pixels of a thing have a pixel of another one next to them."""
    square = np.ones((3, 3), np.uint8)
    highest = cv2.dilate(owners, square)
    # Nobody's ground is no other thing.
    lowest = cv2.erode(np.where(owners == 0, np.uint8(255), owners), square)
    return np.asarray((owners > 0) & (lowest < 255) & (highest != lowest))
