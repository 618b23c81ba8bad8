"""Correction: move the shown point, with or without objects, knowing what was said before.

Paper, Methods, "Correction Module".
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from w2c.errors import RefusedError
from w2c.messages import PhraseEvidence
from w2c_dialogue.answers import PointAnswer, read
from w2c_dialogue.expressions import (
    ImagePoint,
    UnknownSymbolError,
    correction_symbols,
    evaluate_point,
)
from w2c_dialogue.interfaces import Frame, LanguageModel
from w2c_dialogue.prompts.base import CorrectionScene, PromptSet
from w2c_dialogue.prompts.numerals import check_numbers
from w2c_dialogue.relative import OUTSIDE
from w2c_dialogue.sight import Prediction, scene_objects, unknown_warnings
from w2c_dialogue.utterance import Mention, Utterance

NOTICEABLE = 0.5
"""A shorter move is none [px]."""
_UNDO = ("target.u-last.du", "target.v-last.dv")
_BACK = frozenset({"back", "before", "previous", "restore", "return", "revert", "undo"})
"""Words of who takes a move back. A model that writes numbers takes it back by its length"""


@dataclass(frozen=True)
class CorrectedPoint:
    """Where the target goes."""

    prediction: Prediction
    undo: bool
    """It takes back the last correction, which is then forgotten: undo can be said twice."""


def correct(
    model: LanguageModel,
    prompts: PromptSet,
    frame: Frame,
    *,
    utterance: Utterance,
    mentions: Sequence[Mention],
    evidence: Sequence[PhraseEvidence],
    scene: CorrectionScene,
) -> CorrectedPoint:
    """Return the corrected target. `scene.objects` is filled here, from the evidence.

    Args:
        model: Writes the arithmetic.
        prompts: Of that model.
        frame: The picture.
        utterance: The correction.
        mentions: Its words for objects, in order.
        evidence: What grounding sees of each.
        scene: The target and its history.

    Raises:
        RefusedError: an object has no box, there is no earlier move to speak of, or nothing is to
            change.
        ModelError: the model's answer cannot be followed.
        CallError: a service does not answer.
    """
    scene = replace(scene, objects=scene_objects(evidence))
    size = (frame.width, frame.height)
    point, undo = corrected_point(model, prompts, utterance, mentions, scene, size)
    step = max(abs(point.u - scene.target[0]), abs(point.v - scene.target[1]))
    if step < NOTICEABLE and not point.clipped:
        raise RefusedError(
            "The target stays where it is. Say where to move it, for example: a bit to the left; "
            "or name another place."
        )
    warnings = unknown_warnings(evidence) + ((OUTSIDE,) if point.clipped else ())
    return CorrectedPoint(Prediction(point.u, point.v, scene.objects, warnings), undo)


def corrected_point(
    model: LanguageModel,
    prompts: PromptSet,
    utterance: Utterance,
    mentions: Sequence[Mention],
    scene: CorrectionScene,
    size: tuple[int, int],
) -> tuple[ImagePoint, bool]:
    """Return where a correction moves the target, and whether it only takes back the last move.

    Args:
        model: Writes the arithmetic.
        prompts: Of that model.
        utterance: The correction.
        mentions: Its words for the objects of the scene, in the same order.
        scene: What it may refer to.
        size: Width and height of the picture [px].

    Raises:
        RefusedError: there is no earlier move to speak of, or a number is none.
        ModelError: the model's answer cannot be followed.
        CallError: the model does not answer.
    """
    check_numbers(utterance)
    asked = (utterance,) if mentions else prompts.parts(utterance)
    answers = [
        read(model.complete(prompts.correct(part, mentions, scene)), PointAnswer) for part in asked
    ]
    x, y = _added_up([one.x for one in answers], "u"), _added_up([one.y for one in answers], "v")
    try:
        point = evaluate_point(x, y, correction_symbols(scene), size)
    except UnknownSymbolError as error:
        if error.symbol.startswith(("first", "last", "moves")):
            raise RefusedError(
                f"You speak of an earlier move, and there are {len(scene.moves)}. "
                "Say a direction, for example: a bit to the left."
            ) from error
        raise
    return point, (x, y) == _UNDO or _takes_back(utterance, point, scene)


def _added_up(expressions: Sequence[str], axis: str) -> str:
    """Return the expression of all moves together; of one alone, as it was written."""
    if len(expressions) == 1:
        return expressions[0]
    moves = "+".join(f"({one}-target.{axis})" for one in expressions)
    return f"target.{axis}+{moves}"


def _takes_back(utterance: Utterance, point: ImagePoint, scene: CorrectionScene) -> bool:
    """Tell whether words take the last move back, and the point is where it was before."""
    if not scene.moves or _BACK.isdisjoint(word.rstrip(",") for word in utterance.folded):
        return False
    last, (u, v) = scene.moves[-1], scene.target
    return abs(point.u - u + last.du) < NOTICEABLE and abs(point.v - v + last.dv) < NOTICEABLE
