"""Relative prediction: the place is described relative to objects (paper, "Relative Positions")."""

import math
from collections.abc import Sequence

from w2c.messages import PhraseEvidence
from w2c_dialogue.answers import PointAnswer, read
from w2c_dialogue.beside import Described, at_its_foot, near_enough
from w2c_dialogue.expressions import clip, evaluate, object_symbols
from w2c_dialogue.interfaces import Frame, Grounding, LanguageModel
from w2c_dialogue.on_surface import onto_surface
from w2c_dialogue.on_thing import onto_thing
from w2c_dialogue.prompts.base import PromptSet, SceneObject
from w2c_dialogue.prompts.numerals import check_numbers
from w2c_dialogue.sight import Prediction, scene_objects, unknown_warnings
from w2c_dialogue.utterance import Mention, Utterance

OUTSIDE = "That is outside the picture; I took the nearest point inside."
TAKEN = "Something is there, or the surface ends; I took the nearest free place."
NOTICED = 0.02
"""Share of the picture's width: who speaks is told of a place that was moved farther"""


def predict(
    model: LanguageModel,
    prompts: PromptSet,
    frame: Frame,
    *,
    utterance: Utterance,
    mentions: Sequence[Mention],
    evidence: Sequence[PhraseEvidence],
    grounding: Grounding,
    pixels_per_cm: float,
) -> Prediction:
    """Return the point that the words describe, by a model's arithmetic on the boxes.

    Args:
        model: Writes the arithmetic.
        prompts: Of that model.
        frame: The picture.
        utterance: The instruction.
        mentions: Its words for the objects, in order.
        evidence: What grounding sees of each.
        grounding: Sees the surface they stand on.
        pixels_per_cm: Scale of the picture there.

    Raises:
        RefusedError: an object has no box, or a number is none.
        ModelError: the model's arithmetic cannot be followed.
        CallError: a service does not answer.
    """
    objects = scene_objects(evidence)
    place = described(
        model,
        prompts,
        utterance=utterance,
        mentions=mentions,
        objects=objects,
        pixels_per_cm=pixels_per_cm,
    )
    near = clip(*near_enough(place, objects, pixels_per_cm), (frame.width, frame.height))
    beside = at_its_foot(near, objects)
    on_it = onto_thing(beside, objects, grounding, frame)
    point = onto_surface(on_it, objects, grounding, frame)
    warnings = unknown_warnings(evidence) + ((OUTSIDE,) if point.clipped else ())
    if math.dist((point.u, point.v), (on_it.u, on_it.v)) > NOTICED * frame.width:
        warnings += (TAKEN,)
    return Prediction(point.u, point.v, objects, warnings)


def described(
    model: LanguageModel,
    prompts: PromptSet,
    *,
    utterance: Utterance,
    mentions: Sequence[Mention],
    objects: Sequence[SceneObject],
    pixels_per_cm: float,
) -> Described:
    """Return the place that words describe.

    Args:
        model: Writes the arithmetic.
        prompts: Of that model.
        utterance: The instruction.
        mentions: Its words for the objects, in order.
        objects: The same, in the picture.
        pixels_per_cm: Scale of the picture there.

    Raises:
        RefusedError: a number is none.
        ModelError: the model's arithmetic cannot be followed.
        CallError: the model does not answer.
    """
    check_numbers(utterance)
    question = prompts.relative(utterance, mentions, objects, pixels_per_cm)
    answer = read(model.complete(question), PointAnswer)
    boxes = [item.box for item in objects]
    symbols = object_symbols(boxes, pixels_per_cm)
    u, v = evaluate(answer.x, symbols), evaluate(answer.y, symbols)
    # Twice as many pixels a centimetre move it by as much as the lengths of the world are in it.
    across = evaluate(answer.x, object_symbols(boxes, 2.0 * pixels_per_cm)) - u
    return Described(u, v, across)
