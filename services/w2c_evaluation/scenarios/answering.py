"""What the operator answers where the robot asks, and the same instruction in other words.

A person sees in the picture which of the things that the robot hesitates between was meant. Of
these things the scripted operator sees what the turn tells of them, their boxes.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import hypot

from w2c.messages import Box, Turn
from w2c_evaluation.scenarios.scenario import Prompt, Side
from w2c_evaluation.scenarios.sight import Pixel

MOST_QUESTIONS = 3
"""In a row that are answered, about the same words"""
NEW_PLACE, CHANGE = "new place", "change"
ORDINALS = ("first", "second", "third", "fourth", "fifth")
FROM_THE_LEFT = " from the left"
SPECK = 0.1
"""Nobody means what is smaller, as a share of the area of what fits best"""
SLACK_CM = 5.0
"""So far beside a box may be what was meant to be on the thing: boxes are not exact"""
SIDES: dict[Side, str] = {
    "left": "to the left of",
    "right": "to the right of",
    "behind": "behind",
    "front": "in front of",
}


@dataclass(frozen=True)
class Question:
    """What the robot asks."""

    options: tuple[str, ...]
    things: tuple[Box, ...] = ()
    """Between which it hesitates, in pixels of the picture that was spoken about"""


@dataclass(frozen=True)
class Wish:
    """What the operator knows of its own words when it is asked about them."""

    centre: Pixel
    """Of the wanted place, in the picture that was spoken about"""
    reach: float
    """So far from the thing that was named the place may be [px]"""
    beside: bool = False
    """The place is beside the thing, and not on it"""
    changes: bool | None = None
    """The words change the shown point (True) or name a place (False); None: they are a yes"""


def read_question(turn: Turn) -> Question | None:
    """Return what a turn asks; None: nothing."""
    if not turn.options:
        return None
    options = tuple(turn.options)
    sightings = [] if turn.evidence is None else turn.evidence.sightings
    asked = [one.boxes for one in sightings if f"'{one.phrase}'" in turn.reply]
    told = re.search(r"I see (\d+)", turn.reply)
    count = len(options) if told is None else int(told[1])
    return Question(options, _apart(asked[-1])[:count] if asked else ())


def choose_option(question: Question, wish: Wish) -> str | None:
    """Return the option that says what was meant; None: none of them does."""
    if set(question.options) == {NEW_PLACE, CHANGE}:
        return None if wish.changes is None else CHANGE if wish.changes else NEW_PLACE
    meant = _nearest(question.things, wish)
    if meant is None:
        return None
    downwards = "upper" in question.options or "lower" in question.options
    order = sorted(question.things, key=_v if downwards else _u)
    place = order.index(meant)
    fitting = (o for o in question.options if _place_of(o, len(order)) == place)
    return next(fitting, None)


def in_other_words(prompt: Prompt) -> Prompt | None:
    """Return the same instruction said otherwise; None where that needs more than one thing."""
    meaning = prompt.meaning
    if len(meaning.things) != 1 or (meaning.position == "relative" and meaning.side is None):
        return None
    thing, limb = next(iter(meaning.things)), meaning.effector.replace("_", " ")
    if meaning.task == "contact":
        where = "on" if meaning.side is None else SIDES[meaning.side]
        return replace(prompt, text=f"put your {limb} {where} the {thing}")
    where = "for" if meaning.side is None else SIDES[meaning.side]
    return replace(prompt, text=f"go with your {limb} {where} the {thing}")


def _nearest(things: Sequence[Box], wish: Wish) -> Box | None:
    """Return the thing that was meant; None: it is not among these."""
    away = [(_distance(box, wish.centre), box) for box in things]
    # What holds a place is not what the place is beside.
    fitting = [one for one in away if one[0] <= wish.reach and not (wish.beside and one[0] == 0.0)]
    return min(fitting, key=lambda pair: pair[0])[1] if fitting else None


def _place_of(option: str, count: int) -> int | None:
    """Return which one of `count` things in a row an option names; None: nothing that is known."""
    if option.endswith(FROM_THE_LEFT):
        word = option.removesuffix(FROM_THE_LEFT)
        return ORDINALS.index(word) if word in ORDINALS else None
    middle = count // 2 if count % 2 else None
    return {"left": 0, "upper": 0, "middle": middle, "right": count - 1, "lower": count - 1}.get(
        option
    )


def _apart(boxes: Sequence[Box]) -> tuple[Box, ...]:
    """Return boxes of different things, best first, without specks."""
    found: list[Box] = []
    for box in boxes:
        speck = _area(box) < SPECK * _area(boxes[0])
        if not speck and not any(_overlap(box, known) for known in found):
            found.append(box)
    return tuple(found)


def _distance(box: Box, pixel: Pixel) -> float:
    """Return how far a pixel is outside a box [px]; 0 inside."""
    u, v = pixel
    return hypot(max(box.left - u, 0.0, u - box.right), max(box.top - v, 0.0, v - box.bottom))


def _overlap(one: Box, other: Box) -> bool:
    across = min(one.right, other.right) - max(one.left, other.left)
    along = min(one.bottom, other.bottom) - max(one.top, other.top)
    return across > 0.0 and along > 0.0


def _area(box: Box) -> float:
    return (box.right - box.left) * (box.bottom - box.top)


def _u(box: Box) -> float:
    return box.left + box.right


def _v(box: Box) -> float:
    return box.top + box.bottom
