"""What the grounding service sees of the objects an utterance names."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import msgspec
import numpy as np

from w2c.errors import RefusedError
from w2c.messages import Array, Box, PhraseEvidence
from w2c_dialogue.cells import middles
from w2c_dialogue.interfaces import Frame, Grounding
from w2c_dialogue.prompts.base import SceneObject
from w2c_dialogue.utterance import Mention, fold

TWIN_SCORE = 0.9
"""A second box of this share of the best score may be meant as well."""
TWIN_AREA = 0.1
"""A box of a smaller share of the best one's area is a speck or a bit of it, not a twin."""
SMALL_WORDS = frozenset({"a", "an", "and", "at", "by", "in", "of", "on", "the", "to", "with"})


@dataclass(frozen=True)
class Prediction:
    """A point in a picture, and what speaks for it."""

    u: float
    v: float
    objects: tuple[SceneObject, ...]
    warnings: tuple[str, ...] = ()


def look(
    grounding: Grounding,
    frame: Frame,
    mentions: Sequence[Mention],
    want: Literal["heatmaps", "boxes"],
) -> list[PhraseEvidence]:
    """Return the evidence for each mention.

    Raises:
        RefusedError: one of them is not in the picture; says which.
        CallError: grounding does not answer.
    """
    phrases = [mention.phrase for mention in mentions]
    evidence = grounding.ground(frame, phrases, want)
    if len(evidence) != len(phrases):
        raise RefusedError(
            f"I asked about {len(phrases)} objects and was told about {len(evidence)}; say it in "
            "other words."
        )
    for phrase, seen in zip(phrases, evidence, strict=True):
        if not seen.found:
            raise RefusedError(_not_found(phrase, seen))
    return evidence


def scene_objects(evidence: Sequence[PhraseEvidence]) -> tuple[SceneObject, ...]:
    """Return the best box of each phrase. Raises RefusedError for a phrase without one."""
    for seen in evidence:
        if not seen.boxes:
            raise RefusedError(_not_found(seen.phrase, seen))
    return tuple(SceneObject(seen.phrase, seen.boxes[0]) for seen in evidence)


def twins(seen: PhraseEvidence) -> tuple[Box, ...]:
    """Return the boxes that fit a phrase alike, best first, apart from each other."""
    found: list[Box] = []
    for box in seen.boxes:
        best = seen.boxes[0]
        alike = box.score >= TWIN_SCORE * best.score and _area(box) >= TWIN_AREA * _area(best)
        if alike and not any(_overlap(box, known) for known in found):
            found.append(box)
    return tuple(found)


def only(seen: PhraseEvidence, box: Box, size: tuple[int, int]) -> PhraseEvidence:
    """Return the evidence of one of several things: what is outside its box is forgotten.

    Args:
        seen: Of all of them.
        box: Of the one.
        size: Width and height of the picture [px].
    """
    point, heatmap = seen.point, seen.heatmap
    if heatmap is not None:
        heatmap = within(heatmap, box, size)
    if point is None or not inside(point, box):
        point = _hottest(heatmap, size) or centre(box)
    return msgspec.structs.replace(seen, boxes=[box], point=point, heatmap=heatmap)


def unknown_warnings(evidence: Sequence[PhraseEvidence]) -> tuple[str, ...]:
    """Say which words the vision model went without."""
    return tuple(
        f"I do not know {_quoted(seen.unknown_words)} and went by the rest of '{seen.phrase}'."
        for seen in evidence
        if seen.unknown_words
    )


def within(heatmap: Array, box: Box, size: tuple[int, int]) -> Array:
    """Return a heatmap (h, w) of a picture of a size, but zero outside a box [px]."""
    height, width = heatmap.shape
    across, along = width / size[0], height / size[1]
    rows = slice(int(box.top * along), math.ceil(box.bottom * along))
    columns = slice(int(box.left * across), math.ceil(box.right * across))
    kept = np.zeros_like(heatmap)
    kept[rows, columns] = heatmap[rows, columns]
    return kept


def _hottest(heatmap: Array | None, size: tuple[int, int]) -> tuple[float, float] | None:
    """Return the pixel of a picture of a size where a heatmap is highest; None: it is cold."""
    if heatmap is None or not heatmap.any():
        return None
    row, column = np.unravel_index([int(heatmap.argmax())], heatmap.shape)
    u, v = middles(row, column, heatmap.shape, size)
    return float(u[0]), float(v[0])


def centre(box: Box) -> tuple[float, float]:
    """Return the middle of a box (u, v) [px]."""
    return 0.5 * (box.left + box.right), 0.5 * (box.top + box.bottom)


def inside(point: tuple[float, float], box: Box) -> bool:
    """Tell whether a pixel (u, v) is in a box: its left and upper edge are, the others are not."""
    return box.left <= point[0] < box.right and box.top <= point[1] < box.bottom


def _area(box: Box) -> float:
    return (box.right - box.left) * (box.bottom - box.top)


def _overlap(one: Box, other: Box) -> bool:
    across = min(one.right, other.right) - max(one.left, other.left)
    along = min(one.bottom, other.bottom) - max(one.top, other.top)
    return across > 0 and along > 0


def _not_found(phrase: str, seen: PhraseEvidence) -> str:
    hint = ""
    if seen.unknown_words:
        hint = f" I do not know {_quoted(seen.unknown_words)}."
        unknown = {fold(word) for word in seen.unknown_words}
        rest = [word for word in phrase.split() if fold(word) not in unknown]
        if any(fold(word) not in SMALL_WORDS for word in rest):
            hint += f" Without that it is '{' '.join(rest)}': try those words."
    return (
        f"I don't see a '{phrase}' in the picture.{hint} "
        "Describe it in other words (colour, shape), or point at it with a click."
    )


def _quoted(words: Sequence[str]) -> str:
    return f"the word{'s' * (len(words) > 1)} " + ", ".join(f"'{word}'" for word in words[:3])
