"""The prompt set of general language models: explanation, five examples, thought first, numbers.

The form of the paper (Methods, "Prompting LLMs"): few-shot prompting and chain of thought, boxes
as text, and arithmetic that is left to a parser.
"""

from collections.abc import Sequence
from typing import Any

import msgspec

from w2c.errors import ModelError
from w2c.messages import ChatMessage
from w2c_dialogue.prompts import large_texts as texts
from w2c_dialogue.prompts.base import (
    EFFECTORS,
    MODULES,
    POSITIONS,
    TASKS,
    CorrectionScene,
    Question,
    SceneObject,
    TaskName,
    schema_of,
)
from w2c_dialogue.prompts.bound import arithmetic_of, words_of
from w2c_dialogue.utterance import LETTERS, Mention, Span, Utterance, fold

_THOUGHT = {"type": "string", "maxLength": 300}
_PHRASE = {"type": "string", "maxLength": 80}
_EXPRESSION = {"type": "string", "pattern": "^[0-9.+*/() -]{1,100}$"}
ARTICLES = frozenset({"the", "a", "an", "that", "this", "your", "my"})


class LargePrompts:
    """Questions for any instruction-following model."""

    name = "large"

    def __init__(self, *, bound: bool = False) -> None:
        """Prepare.

        Args:
            bound: Objects are named in words of the utterance, and expressions are arithmetic of
                short numbers. Large models keep to the examples without, and may paraphrase.
        """
        self._bound = bound
        self._expression = arithmetic_of((), None) if bound else _EXPRESSION

    def select(self, utterance: Utterance) -> Question:
        """Ask which module an utterance is for."""
        constant = _constant(texts.SELECT, texts.SELECT_EXAMPLES)
        return Question(
            "select", (*constant, _user(utterance.text)), len(constant), options=MODULES
        )

    def analyze(self, utterance: Utterance) -> Question:
        """Ask for the kind of position and the words of the objects."""
        fields = {
            "position": {"type": "string", "enum": list(POSITIONS)},
            "objects": self._phrases(utterance),
        }
        return _question("analyze", texts.ANALYZE, texts.ANALYZE_EXAMPLES, utterance.text, fields)

    def objects(self, utterance: Utterance) -> Question:
        """Ask for the words of the objects in a correction."""
        fields = {"objects": self._phrases(utterance)}
        return _question("objects", texts.OBJECTS, texts.OBJECTS_EXAMPLES, utterance.text, fields)

    def read_mention(self, value: str, utterance: Utterance) -> Mention:
        """Return a phrase, without article, and its words if the utterance has them."""
        typed = value.split()
        while len(typed) > 1 and typed[0].lower() in ARTICLES:
            del typed[0]
        words = [fold(word).rstrip(",") for word in typed]
        if not any(words):
            raise ModelError(f"an object is named by '{value[:40]}', expected words")
        plain = [word.rstrip(",") for word in utterance.folded]
        for first in range(len(plain) - len(words) + 1):
            if plain[first : first + len(words)] == words:
                span = Span(first + 1, first + len(words))
                return Mention(utterance.phrase(span), span)
        return Mention(" ".join(typed)[:100], None)

    def relative(
        self,
        utterance: Utterance,
        mentions: Sequence[Mention],
        objects: Sequence[SceneObject],
        pixels_per_cm: float,
    ) -> Question:
        """Ask for a point relative to the objects."""
        del mentions
        lines = [_scale(pixels_per_cm), *map(_describe, objects), utterance.text]
        return _question(
            "relative",
            texts.RELATIVE,
            texts.RELATIVE_EXAMPLES,
            "\n".join(lines),
            self._point_fields(),
        )

    def correct(
        self, utterance: Utterance, mentions: Sequence[Mention], scene: CorrectionScene
    ) -> Question:
        """Ask for the corrected target."""
        del mentions
        lines = [_scale(scene.pixels_per_cm)]
        lines += [
            f"Earlier: '{said}' moved it by [{move.du:.0f}, {move.dv:.0f}]."
            for said, move in zip(scene.instructions, scene.moves, strict=True)
        ]
        lines += [_describe(item) for item in scene.objects]
        if scene.moves:
            lines.append(f"The first point was [{scene.start[0]:.0f}, {scene.start[1]:.0f}].")
        lines += [f"Target is at [{scene.target[0]:.0f}, {scene.target[1]:.0f}].", utterance.text]
        return _question(
            "correct", texts.CORRECT, texts.CORRECT_EXAMPLES, "\n".join(lines), self._point_fields()
        )

    def parts(self, utterance: Utterance) -> tuple[Utterance, ...]:
        """Return the correction as it is: a large model follows both amounts."""
        return (utterance,)

    def effector(self, utterance: Utterance) -> Question:
        """Ask for end effector and task."""
        fields = {
            "effector": {"type": "string", "enum": list(EFFECTORS)},
            "task": {"type": "string", "enum": list(TASKS)},
        }
        return _question(
            "effector", texts.EFFECTOR, texts.EFFECTOR_EXAMPLES, utterance.text, fields
        )

    def _phrases(self, utterance: Utterance) -> dict[str, Any]:
        phrase = words_of(utterance) if self._bound else _PHRASE
        return {"type": "array", "items": phrase, "minItems": 0, "maxItems": len(LETTERS)}

    def _point_fields(self) -> dict[str, Any]:
        return {"x": self._expression, "y": self._expression}


def _question(
    task: TaskName, system: str, examples: texts.Examples, content: str, fields: dict[str, Any]
) -> Question:
    written = tuple((asked, msgspec.json.encode(answer).decode()) for asked, answer in examples)
    constant = _constant(system, written)
    schema = schema_of({"chain_of_thought": _THOUGHT, **fields})
    return Question(task, (*constant, _user(content)), len(constant), schema)


def _constant(system: str, examples: Sequence[tuple[str, str]]) -> tuple[ChatMessage, ...]:
    messages = [ChatMessage(role="system", content=system)]
    for asked, answer in examples:
        messages += [_user(asked), ChatMessage(role="assistant", content=answer)]
    return tuple(messages)


def _user(content: str) -> ChatMessage:
    return ChatMessage(role="user", content=content)


def _scale(pixels_per_cm: float) -> str:
    digits = 0 if pixels_per_cm >= 20.0 else 1 if pixels_per_cm >= 2.0 else 2
    return f"1 cm is {round(pixels_per_cm, digits):g} pixels."


def _describe(item: SceneObject) -> str:
    box = item.box
    u, v = 0.5 * (box.left + box.right), 0.5 * (box.top + box.bottom)
    name = item.phrase[:1].upper() + item.phrase[1:]
    size = f"width={box.right - box.left:.0f} and height={box.bottom - box.top:.0f}"
    return f"{name} is at [{u:.0f}, {v:.0f}] with {size}."
