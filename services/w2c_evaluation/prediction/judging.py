"""Whether a predicted point is accepted, and the first step that went wrong where it is not.

| step | went wrong |
|---|---|
| selector | the words went to another module |
| analyzer | the position is of the other kind, or other objects were heard |
| segmentation | absolute: the thing was not found, or the point on it is not accepted |
| detection | relative: a thing was not found, or its box overlaps the true one by less than half |
| expression | relative: the boxes are right, and the point is not |

Without the true boxes (pictures of other makers) a relative miss whose things were found is
`detection or expression`.
"""

from collections.abc import Sequence
from typing import Any

import msgspec

from w2c_evaluation.benchmark.dataset import Mask
from w2c_evaluation.benchmark.record import BoxEdges, NamedThing, Record

STEPS = (
    "selector",
    "analyzer",
    "segmentation",
    "detection",
    "expression",
    "detection or expression",
)
LEAST_OVERLAP = 0.5
"""Intersection over union of a box that is right"""
ARTICLES = frozenset({"the", "a", "an", "that", "this", "your", "my"})


class Answer(msgspec.Struct, frozen=True, kw_only=True):
    """What became of one prompt with one combination of models."""

    models: tuple[str, str, str]
    """Names of language model, detector and segmenter"""
    digest: str
    """Of the flags of all three"""
    repetition: int
    id: str
    hit: bool
    error: str = ""
    """The first step that went wrong; "" for a hit"""
    reason: str = ""
    """Why a step gave up"""
    point: tuple[float, float] | None = None
    position: str = ""
    """As heard"""
    phrases: tuple[str, ...] = ()
    boxes: tuple[BoxEdges, ...] = ()
    asks: bool = False
    """The dialogue would have asked which of several things is meant"""


def accepts(mask: Mask, point: tuple[float, float] | None) -> bool:
    """Say whether a mask (h, w) accepts a point (u, v) [px]."""
    if point is None:
        return False
    height, width = mask.shape
    column, row = min(int(point[0]), width - 1), min(int(point[1]), height - 1)
    return column >= 0 and row >= 0 and bool(mask[row, column])


def first_error(record: Record, predicted: Any) -> str:
    """Return the step that went wrong first of a prediction that was not accepted."""
    if predicted.failed in ("selector", "analyzer"):
        return str(predicted.failed)
    if predicted.module != "prediction":
        return "selector"
    if predicted.position != record.position or _heard_others(record.things, predicted.phrases):
        return "analyzer"
    return (
        "segmentation" if predicted.position == "absolute" else _relative_error(record, predicted)
    )


def _relative_error(record: Record, predicted: Any) -> str:
    """Return whether the boxes or the arithmetic were wrong."""
    if predicted.failed == "detection":
        return "detection"
    if record.things is None:
        return "expression" if predicted.failed else "detection or expression"
    boxes = [(box.left, box.top, box.right, box.bottom) for box in predicted.boxes]
    return "expression" if _all_found(record.things, boxes) else "detection"


def _heard_others(things: Sequence[NamedThing] | None, phrases: Sequence[str]) -> bool:
    """Say whether the objects that were heard are not those of the prompt, in order."""
    if things is None:
        return not phrases
    return [plain(thing.words) for thing in things] != [plain(phrase) for phrase in phrases]


def _all_found(things: Sequence[NamedThing], boxes: Sequence[BoxEdges]) -> bool:
    return len(things) == len(boxes) and all(
        overlap(thing.box, box) >= LEAST_OVERLAP for thing, box in zip(things, boxes, strict=True)
    )


def overlap(one: BoxEdges, other: BoxEdges) -> float:
    """Return intersection over union of two boxes."""
    across = min(one[2], other[2]) - max(one[0], other[0])
    along = min(one[3], other[3]) - max(one[1], other[1])
    if across <= 0 or along <= 0:
        return 0.0
    shared = across * along
    areas = sum((box[2] - box[0]) * (box[3] - box[1]) for box in (one, other))
    return float(shared / (areas - shared))


def plain(phrase: str) -> str:
    """Return a phrase in lower case, without punctuation and its article."""
    words = "".join(c if c.isalnum() else " " for c in phrase.lower()).split()
    return " ".join(words[1:] if len(words) > 1 and words[0] in ARTICLES else words)
