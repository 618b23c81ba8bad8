"""What Florence-2 writes about places, read token by token. Pure functions.

It writes words and locations; a location is one of 1000 bins across or down the picture, and comes
with the share of the model's certainty that lay on it and its neighbours. Polygons of one thing are
separated by a token of their own, things by words.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from w2c_grounding.adapters import Polygon
from w2c_grounding.family import ScoredBox

BINS = 1000

NEIGHBOURS = 10
"""Bins to either side that mean the same place: one hundredth of the picture. Detectors are not
sure of the thousandth, and the certainty of a single bin says little."""

MAX_THINGS = 50
"""Of one answer; a model that repeats itself would write more"""


@dataclass(frozen=True)
class Location:
    """A location token; any other token is None in the sequences below."""

    bin: int
    certainty: float
    """0 to 1"""


Tokens = Sequence[Location | None]


def boxes_of(tokens: Tokens, width: int, height: int) -> tuple[ScoredBox, ...]:
    """Return the boxes of an answer: left, top, right, bottom, one after the other.

    Numbers that make no whole box are left out. The score is the geometric mean of the certainties.

    Args:
        tokens: Of one answer, in order.
        width: Of the picture [px].
        height: Of the picture [px].
    """
    boxes = []
    for run in _runs(tokens):
        for at in range(0, len(run) - len(run) % 4, 4):
            left, top, right, bottom = _pixels(run[at : at + 4], width, height)
            boxes.append(ScoredBox(left, top, right, bottom, _certainty(run[at : at + 4])))
    return tuple(boxes[:MAX_THINGS])


def polygons_of(tokens: Tokens, width: int, height: int) -> tuple[list[Polygon], list[float]]:
    """Return the polygons of an answer, each with at least three corners, and their scores."""
    polygons: list[Polygon] = []
    scores: list[float] = []
    for run in list(_runs(tokens))[:MAX_THINGS]:
        corners = _pixels(run[: len(run) - len(run) % 2], width, height)
        if len(corners) >= 6:
            polygons.append(list(zip(corners[::2], corners[1::2], strict=True)))
            scores.append(_certainty(run))
    return polygons, scores


def _runs(tokens: Tokens) -> Iterable[list[Location]]:
    """Yield the stretches of locations with nothing else between them."""
    run: list[Location] = []
    for token in (*tokens, None):
        if token is not None:
            run.append(token)
        elif run:
            yield run
            run = []


def _pixels(locations: Sequence[Location], width: int, height: int) -> list[float]:
    """Return the middles of bins, in turn across and down [px]."""
    sizes = (width, height)
    return [(one.bin + 0.5) / BINS * sizes[index % 2] for index, one in enumerate(locations)]


def _certainty(locations: Sequence[Location]) -> float:
    logarithms = [math.log(max(one.certainty, 1e-9)) for one in locations]
    return math.exp(sum(logarithms) / len(logarithms))
