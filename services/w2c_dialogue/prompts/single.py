"""One prompt for everything, instead of one a module: what the paper's split is compared with.

Paper, Experiments: "breaking down larger tasks into smaller subtasks enables smaller models to
achieve a success rate comparable to larger models". The model names the objects, says how the
place relates to them, and writes the arithmetic, in one answer. The objects are looked for only
afterwards, so that the arithmetic is in symbols of boxes that it has not seen.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import msgspec

from w2c.messages import ChatMessage
from w2c_dialogue.interfaces import Choice, LanguageModel
from w2c_dialogue.prompts.base import (
    POSITIONS,
    CorrectionScene,
    PromptSet,
    Question,
    SceneObject,
    schema_of,
)
from w2c_dialogue.utterance import LETTERS, Mention, Utterance

SYSTEM = (
    "You read an instruction that tells a humanoid robot where to put a hand or a foot, and work "
    "out the point in its camera picture. x grows to the right, y grows downwards; behind or "
    "farther is higher in the picture (smaller y), in front of or nearer is lower. Find the "
    "objects that describe the place, in the order of mention, copied exactly as they are "
    "written, without article; hands and feet of the robot are never objects. The position is "
    "absolute when the place is on an object or the object itself, else relative. The first "
    "object's box is a, the second's b, the third's c; a box has left, right, top, bottom, width, "
    "height and its middle u, v, and cm is one centimetre. Beside an object means outside its "
    "box: 0.2 of its width or height away from the edge unless a distance is given. Think first, "
    "in one or two short sentences. Give x and y as arithmetic of these. Answer in JSON."
)
EXAMPLES: tuple[tuple[str, str, str, tuple[str, ...], str, str], ...] = (
    (
        "Lean on the grey filing cabinet with your left hand.",
        "The hand goes on the cabinet itself.",
        "absolute",
        ("grey filing cabinet",),
        "a.u",
        "a.v",
    ),
    (
        "put your right palm a bit left of the thing with the long spout",
        "Left of a thing, outside its box.",
        "relative",
        ("thing with the long spout",),
        "a.left - 0.15 * a.width",
        "a.v",
    ),
    (
        "support yourself between the kettle and the bread bin",
        "The place is between two objects: the middle of both.",
        "relative",
        ("kettle", "bread bin"),
        "(a.u + b.u) / 2",
        "(a.v + b.v) / 2",
    ),
    (
        "Set your left foot 8 cm in front of the bucket",
        "In front is lower in the picture, 8 cm below the box.",
        "relative",
        ("bucket",),
        "a.u",
        "a.bottom + 8 * cm",
    ),
    (
        "rest your left hand on the right end of the workbench",
        "Just inside the right edge of the box.",
        "relative",
        ("workbench",),
        "a.right - 0.15 * a.width",
        "a.v",
    ),
)
"""What is asked, the thought, position, objects, x, y"""
_EXPRESSION = {"type": "string", "pattern": "^[a-z0-9.+*/() -]{1,80}$"}


class SinglePrompt:
    """A prompt set whose analyzer is asked for the point as well."""

    def __init__(self, prompts: PromptSet) -> None:
        self._prompts = prompts
        self.name = f"{prompts.name}, single_prompt"

    def analyze(self, utterance: Utterance) -> Question:
        """Ask for position, objects and expressions at once."""
        constant = [ChatMessage(role="system", content=SYSTEM)]
        for asked, thought, position, objects, x, y in EXAMPLES:
            answer = {
                "chain_of_thought": thought,
                "position": position,
                "objects": objects,
                "x": x,
                "y": y,
            }
            constant += [
                ChatMessage(role="user", content=asked),
                ChatMessage(role="assistant", content=msgspec.json.encode(answer).decode()),
            ]
        phrase = {"type": "string", "maxLength": 80}
        fields = {
            "chain_of_thought": {"type": "string", "maxLength": 300},
            "position": {"type": "string", "enum": list(POSITIONS)},
            "objects": {"type": "array", "items": phrase, "minItems": 0, "maxItems": len(LETTERS)},
            "x": _EXPRESSION,
            "y": _EXPRESSION,
        }
        messages = (*constant, ChatMessage(role="user", content=utterance.text))
        return Question("analyze", messages, len(constant), schema_of(fields))

    def select(self, utterance: Utterance) -> Question:
        """Ask which module an utterance is for."""
        return self._prompts.select(utterance)

    def objects(self, utterance: Utterance) -> Question:
        """Ask for the `objects` of a correction."""
        return self._prompts.objects(utterance)

    def read_mention(self, value: str, utterance: Utterance) -> Mention:
        """Return what an entry of `objects` names. Raises ModelError."""
        return self._prompts.read_mention(value, utterance)

    def relative(
        self,
        utterance: Utterance,
        mentions: Sequence[Mention],
        objects: Sequence[SceneObject],
        pixels_per_cm: float,
    ) -> Question:
        """Ask for a point relative to objects."""
        return self._prompts.relative(utterance, mentions, objects, pixels_per_cm)

    def correct(
        self, utterance: Utterance, mentions: Sequence[Mention], scene: CorrectionScene
    ) -> Question:
        """Ask for the corrected target."""
        return self._prompts.correct(utterance, mentions, scene)

    def parts(self, utterance: Utterance) -> tuple[Utterance, ...]:
        """Return what the other set returns."""
        return self._prompts.parts(utterance)

    def effector(self, utterance: Utterance) -> Question:
        """Ask for `effector` and `task`."""
        return self._prompts.effector(utterance)


class AskedOnce:
    """A language model that is asked the single prompt only; the rest is taken from its answer."""

    def __init__(self, model: LanguageModel) -> None:
        self._model = model
        self._answer: dict[str, Any] = {}

    @property
    def language_model(self) -> str:
        """Name of the model that answered last."""
        return self._model.language_model

    def complete(self, question: Question) -> Any:
        """Return the model's answer, or the part of it that a later module asks for."""
        if question.task == "relative":
            return {axis: self._answer.get(axis) for axis in ("x", "y")}
        value = self._model.complete(question)
        self._answer = value if isinstance(value, dict) else {}
        return value

    def choose(self, question: Question, log_prior: Mapping[str, float]) -> Choice:
        """Return `prediction`: a prompt that does everything has no module to choose."""
        del question, log_prior
        return Choice("prediction", {"prediction": 1.0})
