"""The prompt set of the embedded model: a tag and the utterance, nothing else.

The model is trained on exactly these texts (`w2c_dialogue.corpus`), so they need no explanation
and no examples. It points at words by number, speaks of objects as A, B, C and of quantities by
symbol: numbers are copied, never computed. See `w2c_dialogue.expressions` for the symbols. A bound
answer has no symbol and no number that the scene and the utterance do not have.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace

from w2c.errors import ModelError
from w2c.messages import Box, ChatMessage
from w2c_dialogue.expressions import correction_symbols, object_symbols
from w2c_dialogue.prompts import two_ways
from w2c_dialogue.prompts.base import (
    EFFECTORS,
    MODULES,
    POSITIONS,
    TASKS,
    CorrectionScene,
    Move,
    Question,
    SceneObject,
    TaskName,
    schema_of,
)
from w2c_dialogue.prompts.bound import arithmetic_of, numbers_of
from w2c_dialogue.prompts.limb_words import named_limb
from w2c_dialogue.prompts.numerals import in_digits, with_digits
from w2c_dialogue.prompts.spans import spans_schema
from w2c_dialogue.utterance import Mention, Span, Utterance

IMAGE_WIDTH = 1280.0
MAX_EXPRESSION = 60
REMEMBERED_MOVES = 3
NAMED_MOVES = 7
"""How far back a bound expression may refer: with three objects, 63 of at most 64 symbols"""
EXPRESSION_PATTERN = rf"^[a-z0-9.+*/()\[\]-]{{1,{MAX_EXPRESSION}}}$"
"""Grammar of the characters only; `expressions.evaluate` is the judge of the rest."""


class EmbeddedPrompts:
    """Questions for the model that is shipped with this repository."""

    name = "embedded"

    def __init__(self, *, bound: bool = True) -> None:
        """Prepare.

        Args:
            bound: Expressions have symbols of the scene and numbers of the utterance only.
        """
        self._bound = bound

    def select(self, utterance: Utterance) -> Question:
        """Ask which module an utterance is for."""
        return Question("select", _messages("select", utterance.folded_text), 1, options=MODULES)

    def analyze(self, utterance: Utterance) -> Question:
        """Ask for the kind of position and the words of the objects."""
        properties = {
            "position": {"type": "string", "enum": list(POSITIONS)},
            "objects": spans_schema(utterance),
        }
        return Question(
            "analyze", _messages("analyze", utterance.numbered()), 1, schema_of(properties)
        )

    def objects(self, utterance: Utterance) -> Question:
        """Ask for the words of the objects in a correction."""
        properties = {"objects": spans_schema(utterance)}
        return Question(
            "objects", _messages("objects", utterance.numbered()), 1, schema_of(properties)
        )

    def read_mention(self, value: str, utterance: Utterance) -> Mention:
        """Return the phrase that `5-6` names."""
        first, dash, last = value.partition("-")
        numbers = [
            text for text in (first, last) if text.isascii() and text.isdigit() and len(text) <= 3
        ]
        if not dash or len(numbers) < 2:
            raise ModelError(f"an object is named by '{value[:40]}', expected words such as '5-6'")
        span = Span(int(first), int(last))
        return Mention(utterance.phrase(span), span)

    def relative(
        self,
        utterance: Utterance,
        mentions: Sequence[Mention],
        objects: Sequence[SceneObject],
        pixels_per_cm: float,
    ) -> Question:
        """Ask for a point relative to the objects. The scale is a symbol, so it is not shown."""
        boxes = [o.box for o in objects]
        said = _lettered(utterance, mentions)
        content = f"{describe_boxes(boxes)}\n{said}"
        schema = self._point_schema(object_symbols(boxes, pixels_per_cm), said)
        return Question("relative", _messages("relative", content), 1, schema)

    def correct(
        self, utterance: Utterance, mentions: Sequence[Mention], scene: CorrectionScene
    ) -> Question:
        """Ask for the corrected target."""
        known = describe_moves(scene.moves)
        if scene.objects:
            known += f", {describe_boxes([o.box for o in scene.objects])}"
        said = _lettered(utterance, mentions)
        content = f"{known}\n{said}"
        named = replace(scene, moves=scene.moves[-NAMED_MOVES:])
        schema = self._point_schema(correction_symbols(named), said)
        return Question("correct", _messages("correct", content), 1, schema)

    def parts(self, utterance: Utterance) -> tuple[Utterance, ...]:
        """Return each direction with its amount: asked for both, the model mixes them up."""
        return two_ways.parts(with_digits(utterance))

    def effector(self, utterance: Utterance) -> Question:
        """Ask for end effector and task."""
        limb = named_limb(utterance)
        properties = {
            "effector": {"type": "string", "enum": list(EFFECTORS) if limb is None else [limb]},
            "task": {"type": "string", "enum": list(TASKS)},
        }
        return Question(
            "effector", _messages("effector", utterance.folded_text), 1, schema_of(properties)
        )

    def _point_schema(self, symbols: Iterable[str], said: str) -> dict[str, object]:
        """Return the schema of two expressions, of words as the model reads them."""
        expression: dict[str, object] = {"type": "string", "pattern": EXPRESSION_PATTERN}
        if self._bound:
            expression = arithmetic_of(symbols, numbers_of(said))
        return schema_of({"x": expression, "y": expression})


def _lettered(utterance: Utterance, mentions: Sequence[Mention]) -> str:
    """Return the words with letters for objects and digits for numbers of several words."""
    return " ".join(in_digits(utterance.with_letters([m.span for m in mentions]).split()))


def describe_boxes(boxes: Sequence[Box]) -> str:
    """Return what the model must know of the boxes: where there is room, and their order.

    One object is `A left`, `A middle` or `A right` in the picture; two are `A left of B`, `A right
    of B`, `A above B` or `A below B`, along the axis with the wider gap.
    """
    if not boxes:
        return "nothing"
    if len(boxes) == 1:
        u = 0.5 * (boxes[0].left + boxes[0].right)
        third = IMAGE_WIDTH / 3.0
        return "A left" if u < third else "A right" if u > 2.0 * third else "A middle"
    a, b = boxes[:2]
    gaps = {
        "left of": b.left - a.right,
        "right of": a.left - b.right,
        "above": b.top - a.bottom,
        "below": a.top - b.bottom,
    }
    return f"A {max(gaps, key=lambda relation: gaps[relation])} B"


def describe_moves(moves: Sequence[Move]) -> str:
    """Return the directions of the latest corrections, oldest first: `past left, right up`."""
    if not moves:
        return "past none"
    return "past " + ", ".join(_direction(move) for move in moves[-REMEMBERED_MOVES:])


def _direction(move: Move) -> str:
    """Return the words of the parts of a move that matter, `still` for none."""
    longest = max(abs(move.du), abs(move.dv))
    if longest < 0.5:
        return "still"
    words = []
    if abs(move.du) > 0.3 * longest:
        words.append("right" if move.du > 0 else "left")
    if abs(move.dv) > 0.3 * longest:
        words.append("down" if move.dv > 0 else "up")
    return " ".join(words)


def _messages(tag: TaskName, content: str) -> tuple[ChatMessage, ...]:
    return (ChatMessage(role="system", content=tag), ChatMessage(role="user", content=content))
