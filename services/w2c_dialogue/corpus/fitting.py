"""Which expression explains a point that a person confirmed.

Several often do: 20 px to the left may be `a bit`, 2 cm, or the last move once more. A wrong
expression would teach a wrong word, so there is an answer only where one meaning fits and no number
was said.
"""

from collections.abc import Iterator, Mapping, Sequence

from w2c.messages import Box
from w2c_dialogue.corpus import locations
from w2c_dialogue.corpus.measures import NUMBER_WORDS
from w2c_dialogue.corpus.moves import STEPS
from w2c_dialogue.corpus.steering import WAYS, term
from w2c_dialogue.expressions import evaluate
from w2c_dialogue.prompts.base import CorrectionScene
from w2c_dialogue.prompts.embedded import describe_boxes
from w2c_dialogue.utterance import LETTERS, Utterance

Found = tuple[str, str]
"""Expressions of u and v"""
CLOSE = 3.0
"""A point is explained by an expression that comes this near in u and in v [px]"""
APART = 6.0
"""...and by no other of which some comes this near: the person may not have been exact [px]"""
_SIZES = (locations.CLOSE, locations.USUAL, locations.DISTANT)
_SHARES = ("0.25", "0.4", "0.5", "0.7")
_TIMES = ("0.5", "", "1.5", "2", "3")


def place_of_point(
    boxes: Sequence[Box],
    symbols: Mapping[str, float],
    point: tuple[float, float],
    utterance: Utterance,
) -> Found | None:
    """Return the only place relative to boxes that explains a point, or None."""
    return _only(_places(boxes), symbols, point, utterance)


def correction_of_point(
    scene: CorrectionScene,
    symbols: Mapping[str, float],
    point: tuple[float, float],
    utterance: Utterance,
) -> Found | None:
    """Return the only correction that explains a point, or None."""
    return _only(_corrections(scene), symbols, point, utterance)


def says_number(utterance: Utterance) -> bool:
    """Say whether digits, words of numbers or body measures are in an utterance."""
    words = {word.strip(",") for word in utterance.folded}
    return bool(words & (_NUMBERS | _MEASURES)) or any(c.isdigit() for word in words for c in word)


_NUMBERS = frozenset(word for name in NUMBER_WORDS for word in name.split()) - {"a", "of"}
_MEASURES = frozenset(
    ("width", "breadth", "length", "finger", "finger's", "fingers", "thumb", "thumb's", "thumbs")
)


def _only(
    candidates: Iterator[Found],
    symbols: Mapping[str, float],
    point: tuple[float, float],
    utterance: Utterance,
) -> Found | None:
    if says_number(utterance):
        return None
    near: dict[Found, float] = {}
    for x, y in candidates:
        u, v = evaluate(x, symbols), evaluate(y, symbols)
        away = max(abs(u - point[0]), abs(v - point[1]))
        if away <= APART:
            near[x, y] = away
    if len(near) != 1:
        return None
    found, away = next(iter(near.items()))
    return found if away <= CLOSE else None


def _places(boxes: Sequence[Box]) -> Iterator[Found]:
    for letter in LETTERS[: len(boxes)]:
        for du in (-1, 0, 1):
            for dv in (-1, 0, 1):
                if du or dv:
                    yield locations.inside(letter, du, dv)
                    yield from (locations.beside(letter, du, dv, size) for size in _SIZES)
    if len(boxes) > 1:
        yield locations.BOXES_OF_BETWEEN[describe_boxes(boxes)]
        for share in ("0.25", "0.33", "0.67", "0.75"):
            yield f"a.u+{share}*(b.u-a.u)", f"a.v+{share}*(b.v-a.v)"
    if len(boxes) > 2:
        yield "(a.u+b.u+c.u)/3", "(a.v+b.v+c.v)/3"


def _corrections(scene: CorrectionScene) -> Iterator[Found]:
    yield "target.u", "target.v"
    for way, (du, dv) in WAYS.items():
        for size in STEPS.values():
            yield term("target.u", du, size), term("target.v", dv, size)
            for across in ("left", "right") if way in ("up", "down") else ():
                for other in STEPS.values():
                    sideways = term("target.u", WAYS[across][0], other)
                    yield sideways, term("target.v", dv, size)
    if scene.moves:
        for times in _TIMES:
            for sign in "+-":
                part = f"{sign}{times}*" if times else sign
                yield f"target.u{part}last.du", f"target.v{part}last.dv"
        if len(scene.moves) > 1:
            yield "start.u", "start.v"
    for letter in LETTERS[: len(scene.objects)]:
        yield f"{letter}.u", f"{letter}.v"
        yield f"{letter}.u", "target.v"
        yield "target.u", f"{letter}.v"
        for share in _SHARES:
            u, v = (f"{share}*({letter}.{axis}-target.{axis})" for axis in "uv")
            yield f"target.u+{u}", f"target.v+{v}"
        for size in STEPS.values():
            for sign in "+-":
                u, v = (f"{sign}{size}*{letter}.way.{axis}" for axis in "uv")
                yield f"target.u{u}", f"target.v{v}"
    yield from _places([thing.box for thing in scene.objects])
