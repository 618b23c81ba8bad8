"""What the grounding service sees of the objects an utterance names."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from w2c.errors import RefusedError
from w2c.messages import Box, PhraseEvidence
from w2c_dialogue.interfaces import Frame, Grounding
from w2c_dialogue.prompts.base import SceneObject
from w2c_dialogue.utterance import Mention

TWIN_SCORE = 0.9
"""A second box of this share of the best score may be meant as well."""


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
            f"I asked about {len(phrases)} objects and was told about {len(evidence)}; say it "
            "again."
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


def twin_warnings(evidence: Sequence[PhraseEvidence]) -> tuple[str, ...]:
    """Say where two things fit a phrase equally well."""
    return tuple(
        f"I see more than one '{seen.phrase}' and took the best match; say which one if it is the "
        "wrong one."
        for seen in evidence
        if len(seen.boxes) > 1
        and seen.boxes[1].score >= TWIN_SCORE * seen.boxes[0].score
        and not _overlap(seen.boxes[0], seen.boxes[1])
    )


def _overlap(one: Box, other: Box) -> bool:
    across = min(one.right, other.right) - max(one.left, other.left)
    along = min(one.bottom, other.bottom) - max(one.top, other.top)
    return across > 0 and along > 0


def _not_found(phrase: str, seen: PhraseEvidence) -> str:
    unknown = ", ".join(f"'{word}'" for word in seen.unknown_words[:3])
    hint = f" I do not know the word {unknown}." if unknown else ""
    return (
        f"I don't see a '{phrase}' in the picture.{hint} "
        "Describe it in other words (colour, shape), or point at it with a click."
    )
