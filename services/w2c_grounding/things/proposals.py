"""From what the network of things answers to things: which places show the same one. Pure."""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from w2c_grounding.evidence import Mask, logistic

THERE = 0.4
"""Probability of a thing at a place that may show one"""
SURE = 0.25
"""Of a thing: that it is there, and that its box fits"""
ALIKE = 0.7
"""Intersection over union of boxes of places that show one thing"""
SAME = 0.5
"""Of boxes of two groups of such places that may show one thing"""
FEW = 0.5
"""Of the places of the larger one: where the smaller one has less, it is a fringe of that. Of two
things that lie on each other both are seen at many places"""
BORDER = 0.006
"""Of the sides of the picture: an end of a box that is so near to the border lies on it"""
MOST = 32
"""Things of a picture, the surest ones"""
Floats = npt.NDArray[np.float32]


@dataclass(frozen=True)
class Thing:
    """Something in a picture, whatever it is called."""

    box: tuple[float, float, float, float]
    """Left, top, right, bottom as shares of the picture's sides"""
    places: Mask
    """(rows, columns) where it is seen"""
    score: float


def things_of(there: Floats, fits: Floats, boxes: Floats) -> tuple[Thing, ...]:
    """Return the things of a picture, the surest first.

    Of the places that are left the surest one names a thing; places whose boxes are nearly the same
    show that thing as well.

    Args:
        there: (rows, columns) logits that a thing is seen.
        fits: (rows, columns) logits that its box fits.
        boxes: (rows, columns, 4), as of `Thing`.
    """
    seen = logistic(there)
    rows, columns = np.nonzero(seen >= THERE)
    scores = (seen * logistic(fits))[rows, columns]
    ends = np.clip(boxes[rows, columns], 0.0, 1.0)
    left = np.ones(len(rows), np.bool_)
    things: list[Thing] = []
    for first in np.argsort(-scores, kind="stable"):
        if not left[first]:
            continue
        if scores[first] < SURE or len(things) == MOST:
            break
        mine = left & (_overlaps(ends[first], ends) >= ALIKE)
        mine[first] = True
        left &= ~mine
        places = np.zeros(seen.shape, np.bool_)
        places[rows[mine], columns[mine]] = True
        box = np.average(ends[mine], axis=0, weights=scores[mine])
        _add(Thing(_within(box), places, float(scores[first])), things)
    return tuple(things)


def _add(found: Thing, things: list[Thing]) -> None:
    """Add a thing, or its places to those of one that it is the fringe of, or the other way."""
    count = np.count_nonzero(found.places)
    for number, thing in enumerate(things):
        others = np.count_nonzero(thing.places)
        alike = _overlaps(np.array(found.box, np.float32), np.array([thing.box], np.float32))[0]
        if alike >= SAME and min(count, others) < FEW * max(count, others):
            things[number] = replace(thing, places=thing.places | found.places)
            return
    things.append(found)


def _within(box: Floats) -> tuple[float, float, float, float]:
    """Return a box of which an end so near to the border that nobody knows lies on it."""
    ends = np.where(box < BORDER, 0.0, np.where(box > 1.0 - BORDER, 1.0, box))
    left, top, right, bottom = (float(one) for one in ends)
    return left, top, right, bottom


def _overlaps(box: Floats, others: Floats) -> Floats:
    """Return the intersection over union of a box (4,) with others (n, 4)."""
    low = np.maximum(box[:2], others[:, :2])
    high = np.minimum(box[2:], others[:, 2:])
    common = np.clip(high - low, 0.0, None).prod(axis=1)
    joint = (box[2:] - box[:2]).prod() + (others[:, 2:] - others[:, :2]).prod(axis=1) - common
    return np.asarray(common / np.maximum(joint, 1e-9), np.float32)
