"""Lines of a batch: what is asked, and what is answered.

Coordinates are pixels of the picture, u to the right, v down. Fields beyond these are ignored, so
that a file of questions may hold the right answers, too.
"""

import json
import math
from typing import Annotated, Any

import msgspec

from w2c.messages import Box

Number = Annotated[float, msgspec.Meta(ge=-1e5, le=1e5)]
Size = Annotated[float, msgspec.Meta(gt=0, le=1e5)]
Point = tuple[Number, Number]
PIXELS_PER_CM = 10.0
"""Where nothing is known of the distance"""


class Thing(msgspec.Struct, frozen=True):
    """An object of the picture that the text names: its words, centre and size [px]."""

    phrase: Annotated[str, msgspec.Meta(min_length=1, max_length=200)]
    cx: Number
    cy: Number
    w: Size
    h: Size

    @property
    def box(self) -> Box:
        """The same as edges."""
        return Box(
            left=self.cx - 0.5 * self.w,
            top=self.cy - 0.5 * self.h,
            right=self.cx + 0.5 * self.w,
            bottom=self.cy + 0.5 * self.h,
            score=1.0,
        )


Things = Annotated[list[Thing], msgspec.Meta(max_length=3)]
Seen = Annotated[list[Thing], msgspec.Meta(max_length=50)]
"""Things of a picture; a text need not speak of all of them"""


class Line(msgspec.Struct, frozen=True, kw_only=True, tag_field="task"):
    """What all lines have."""

    id: str | int


class Select(Line, frozen=True, kw_only=True, tag="select"):
    """Which module is this for?"""

    text: str


class Analyze(Line, frozen=True, kw_only=True, tag="analyze"):
    """On a thing or relative to things, and which?"""

    text: str


class Effector(Line, frozen=True, kw_only=True, tag="effector"):
    """Which hand or foot, to lean or to reach?"""

    text: str


class Relative(Line, frozen=True, kw_only=True, tag="relative"):
    """Where is it, relative to these things?"""

    text: str
    objects: Annotated[Seen, msgspec.Meta(min_length=1)]
    px_per_cm: Size = PIXELS_PER_CM


class Correct(Line, frozen=True, kw_only=True, tag="correct"):
    """Where does the target go?"""

    text: str
    target: Point
    previous_moves: Annotated[list[Point], msgspec.Meta(max_length=1000)] = []
    """(du, dv) of earlier corrections, oldest first; the target is after them"""
    objects: Seen = []
    px_per_cm: Size = PIXELS_PER_CM


class Dialogue(Line, frozen=True, kw_only=True, tag="dialogue"):
    """Which modules are the turns of a conversation for?"""

    turns: Annotated[list[str], msgspec.Meta(min_length=1, max_length=1000)]


Question = Select | Analyze | Effector | Relative | Correct | Dialogue
Answer = dict[str, Any]


def decode(line: bytes) -> Question:
    """Return the question of a line; a field that is null is as good as left out.

    Raises:
        ValueError: with what is wrong with it.
    """
    try:
        value = msgspec.json.decode(line)
    except RecursionError as error:
        raise ValueError("JSON is malformed: nested too deeply") from error
    if isinstance(value, dict):
        value = {name: field for name, field in value.items() if field is not None}
    return msgspec.convert(value, Question)  # type: ignore[no-any-return]


def field_of(line: bytes, name: str) -> str | float | None:
    """Return a field of a line that may be no question; None where it has none to be written."""
    try:
        value = json.loads(line)  # more lenient than msgspec: takes 1e999
        found = value.get(name) if isinstance(value, dict) else None
        if isinstance(found, str):
            found.encode()  # refuses half a character
    except (ValueError, RecursionError):
        return None
    if isinstance(found, float) and not math.isfinite(found):
        return None
    return found if isinstance(found, str | int | float) else None
