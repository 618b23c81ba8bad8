"""A user's own dialogues as training data: one turn a line of JSON, what was said and meant.

The fields are those that a recording has of every turn, in the words of `w2c dialogue batch`. Most
may be left out; each that is there teaches one question more (docs/reference/dialogues.md).
"""

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Literal

import msgspec

from w2c.errors import ConfigError, W2CError
from w2c_dialogue.batch.answering import name_things
from w2c_dialogue.batch.lines import PIXELS_PER_CM, Number, Point, Size, Thing, Things
from w2c_dialogue.corpus.fitting import Found, correction_of_point, place_of_point
from w2c_dialogue.corpus.generate import PROMPTS, Example, answer_text, example
from w2c_dialogue.expressions import correction_symbols, evaluate, object_symbols
from w2c_dialogue.prompts.base import CorrectionScene, Move, Question, SceneObject
from w2c_dialogue.utterance import Mention, Utterance, parse

WIDTH, HEIGHT = 1280.0, 720.0
"""Of the pictures in whose pixels steps are counted; others are scaled to their width"""
TOLERANCE = 5.0
"""By how much a point may differ from its own expressions [px of a picture 1280 wide]"""
LONGEST_EXPRESSION = 60
NO_EXPRESSION = "points that no expression explains, or several: give x and y"


class Turn(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One line: what a person said to the robot, and what it was to do."""

    utterance: Annotated[str, msgspec.Meta(min_length=1)]
    module: Literal["prediction", "correction", "confirmation"]
    """An instruction with a new target, a change of the target that is shown, or a yes to it"""
    id: str = ""
    """Where it comes from; not read"""
    image: tuple[Size, Size] = (WIDTH, HEIGHT)
    """Width and height of the picture [px]"""
    objects: Things | None = None
    """What the utterance names, with boxes: its words as typed, centre and size [px]; [] = it names
    nothing, None = not known"""
    position: Literal["absolute", "relative"] | None = None
    """Of an instruction: on the object, or relative to objects"""
    end_effector: (
        Literal["left_hand", "right_hand", "left_foot", "right_foot", "unspecified"] | None
    ) = None
    task_type: Literal["contact", "reach"] | None = None
    target: Point | None = None
    """Of a correction: the point that was shown when it was said [px]"""
    previous_moves: Annotated[list[Point], msgspec.Meta(max_length=1000)] = []
    """(du, dv) of earlier corrections, oldest first; the target is after them"""
    point: Point | None = None
    """The point that was meant: the one that the person confirmed [px]"""
    x: str = ""
    y: str = ""
    """The expressions of that point, as the robot computed it (`a.left-0.2*a.width`)"""
    px_per_cm: Size = PIXELS_PER_CM


@dataclass
class DialogueExamples:
    """What a file of dialogues teaches."""

    examples: list[Example] = field(default_factory=list)
    lines: int = 0
    unused: Counter[str] = field(default_factory=Counter)
    """What gave no example, and how often"""

    @property
    def summary(self) -> str:
        """What was read, and what could not be used, in one line."""
        parts = [f"{self.lines} turns, {len(self.examples)} questions"]
        parts += [f"{count} {what}" for what, count in self.unused.items()]
        return "; ".join(parts)


def read_dialogues(path: Path) -> DialogueExamples:
    """Return the questions that the turns of a file answer.

    Raises:
        ConfigError: it cannot be read, holds no turn, or a line is none; names file, line, field.
    """
    found = DialogueExamples()
    decoder = msgspec.json.Decoder(Turn)
    try:
        lines = path.read_bytes().splitlines()
    except OSError as error:
        raise ConfigError(f"{path} cannot be read: {error.strerror}; give --with FILE") from error
    for number, line in enumerate(lines, 1):
        if not line.strip():
            continue
        try:
            found.examples += examples_of(decoder.decode(line), found.unused)
        except (msgspec.MsgspecError, UnicodeDecodeError, W2CError) as error:
            raise ConfigError(f"{path}, line {number}: {error}") from error
        found.lines += 1
    if not found.examples:
        raise ConfigError(f"{path} holds no turn of a dialogue")
    return found


def examples_of(turn: Turn, unused: Counter[str]) -> Iterator[Example]:
    """Yield the questions that one turn answers.

    Raises:
        ConfigError: fields of it contradict each other.
        ModelError: an expression cannot be read.
        RefusedError: the utterance is empty or too long.
    """
    utterance = parse(turn.utterance)
    yield example(PROMPTS.select(utterance), turn.module)
    if turn.module == "prediction" and turn.end_effector is not None and turn.task_type is not None:
        answer = answer_text({"effector": turn.end_effector, "task": turn.task_type})
        yield example(PROMPTS.effector(utterance), answer)
    if turn.module == "confirmation" or turn.objects is None:
        return
    mentions, objects = _named(turn.objects, turn, utterance)
    spans = [str(mention.span) for mention in mentions]
    if turn.module == "correction":
        yield example(PROMPTS.objects(utterance), answer_text({"objects": spans}))
        yield from _correct(turn, utterance, mentions, objects, unused)
        return
    if turn.position is not None:
        answer = answer_text({"position": turn.position, "objects": spans})
        yield example(PROMPTS.analyze(utterance), answer)
    if turn.position == "relative":
        yield from _relative(turn, utterance, mentions, objects, unused)


Mentions = tuple[Mention, ...]
Objects = tuple[SceneObject, ...]


def _named(named: Things, turn: Turn, utterance: Utterance) -> tuple[Mentions, Objects]:
    """Return the objects with their words, in order of mention, in a picture 1280 wide."""
    scale = _scale(turn)
    things = [
        Thing(thing.phrase, *(scale * value for value in (thing.cx, thing.cy, thing.w, thing.h)))
        for thing in named
    ]
    found = name_things(utterance, things)
    if found is None:
        phrases = ", ".join(f"'{thing.phrase}'" for thing in things)
        raise ConfigError(
            f"of the objects {phrases} not all stand in '{turn.utterance}', word for word"
        )
    return found


def _relative(
    turn: Turn, utterance: Utterance, mentions: Mentions, objects: Objects, unused: Counter[str]
) -> Iterator[Example]:
    if not objects or not (turn.point or turn.x):
        return
    scale = _scale(turn)
    boxes = [thing.box for thing in objects]
    symbols = object_symbols(boxes, turn.px_per_cm * scale)

    def fit(point: Point) -> Found | None:
        return place_of_point(boxes, symbols, point, utterance)

    question = PROMPTS.relative(utterance, mentions, objects, turn.px_per_cm * scale)
    yield from _pointed(turn, symbols, fit, question, unused)


def _correct(
    turn: Turn, utterance: Utterance, mentions: Mentions, objects: Objects, unused: Counter[str]
) -> Iterator[Example]:
    if not (turn.point or turn.x):
        return
    scale = _scale(turn)
    target = _scaled(turn.target, scale)
    if target is None:
        raise ConfigError("a correction with a point needs the target that was shown before")
    moves = tuple(Move(scale * du, scale * dv) for du, dv in turn.previous_moves)
    start = (target[0] - sum(m.du for m in moves), target[1] - sum(m.dv for m in moves))
    scene = CorrectionScene(
        target, start, moves, ("",) * len(moves), objects, turn.px_per_cm * scale
    )
    symbols = correction_symbols(scene)

    def fit(point: Point) -> Found | None:
        return correction_of_point(scene, symbols, point, utterance)

    yield from _pointed(turn, symbols, fit, PROMPTS.correct(utterance, mentions, scene), unused)


def _pointed(
    turn: Turn,
    symbols: dict[str, float],
    fit: Callable[[Point], Found | None],
    question: Question,
    unused: Counter[str],
) -> Iterator[Example]:
    """Yield the question for a point with its expressions: as stated, else as `fit` explains it."""
    point = _scaled(turn.point, _scale(turn))
    answer = _stated(turn, symbols, point)
    if answer is None and point is not None:
        answer = fit(point)
    if answer is None:
        unused[NO_EXPRESSION] += 1
        return
    yield example(question, answer_text({"x": answer[0], "y": answer[1]}))


def _stated(turn: Turn, symbols: dict[str, float], point: Point | None) -> Found | None:
    """Return the expressions of a turn, checked against its point; None without them."""
    if bool(turn.x) != bool(turn.y):
        raise ConfigError("x and y are the two halves of one point: give both or none")
    if not turn.x:
        return None
    for text in (turn.x, turn.y):
        if len(text) > LONGEST_EXPRESSION:
            raise ConfigError(
                f"an expression of {len(text)} characters; the limit is {LONGEST_EXPRESSION}"
            )
    x, y = ("".join(text.split()) for text in (turn.x, turn.y))
    u, v = evaluate(x, symbols), evaluate(y, symbols)
    if point is not None and max(abs(u - point[0]), abs(v - point[1])) > TOLERANCE:
        raise ConfigError(
            f"x and y give ({u:.0f}, {v:.0f}), the point is ({point[0]:.0f}, {point[1]:.0f}), "
            f"in pixels of a picture {WIDTH:.0f} wide: leave out what is wrong"
        )
    return x, y


def _scale(turn: Turn) -> Number:
    return WIDTH / turn.image[0]


def _scaled(point: Point | None, scale: float) -> Point | None:
    return None if point is None else (scale * point[0], scale * point[1])
