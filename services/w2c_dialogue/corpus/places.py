"""Places of the hand-written corpus, as its authors note them: `left(A, {3}cm)`, `between(A,B)`.

    place = name "(" argument { "," argument } ")"

An argument is an object (A, B, C), a word, an amount, or a place. The expressions are those of
`w2c_dialogue.corpus.locations`, so that hand-written and drawn sentences mean the same.
"""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from w2c.errors import ConfigError
from w2c_dialogue.corpus import locations
from w2c_dialogue.corpus.measures import BODY

AMOUNTS = {"close": locations.CLOSE, "far": locations.DISTANT}
UNITS = {"cm": "{}*cm", "mm": "0.1*{}*cm", "inch": "2.54*{}*cm", "px": "{}", **BODY}
CORNERS = {
    "topleft": (-1, -1), "topright": (1, -1), "bottomleft": (-1, 1), "bottomright": (1, 1),
    "left": (-1, 0), "right": (1, 0), "top": (0, -1), "bottom": (0, 1),
}  # fmt: skip

_LENGTH = re.compile(r"([0-9.]+)(cm|mm|inch|px|finger|thumb|hand|foot|arm)")
_PLACE = re.compile(r"([a-z_]+)\((.*)\)")


@dataclass(frozen=True)
class Place:
    """Expressions of a point; `scene` as in `Location`."""

    x: str
    y: str
    scenes: tuple[str, ...] = ("",)
    """Facts about the boxes, one of which is to be made true; ("",) for any"""
    by_scene: tuple[tuple[str, str], ...] = ()
    """The expressions under each of the scenes, where they differ"""


def read_place(text: str) -> Place:
    """Return the place of a note.

    Raises:
        ConfigError: it is none.
    """
    match = _PLACE.fullmatch(text.replace(" ", ""))
    if match is None or match[1] not in _READERS:
        raise ConfigError(f"'{text}' is no place; known: {', '.join(_READERS)}, each with (...)")
    try:
        return _READERS[match[1]](match[1], _arguments(match[2]))
    except (KeyError, ValueError, IndexError) as error:
        raise ConfigError(f"'{text}' has an argument that {match[1]} cannot take") from error


def length(text: str) -> str:
    """Return the expression of `3cm`, `20px`, ... Raises ValueError for anything else."""
    match = _LENGTH.fullmatch(text)
    if match is None:
        raise ValueError(text)
    return UNITS[match[2]].format(match[1])


def _arguments(text: str) -> list[str]:
    """Split at the commas that stand in no inner parentheses."""
    parts, depth = [""], 0
    for character in text:
        depth += (character == "(") - (character == ")")
        if character == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += character
    return parts


def _letter(text: str) -> str:
    if text not in ("A", "B", "C"):
        raise ValueError(text)
    return text.lower()


def _amount(arguments: Sequence[str]) -> str:
    if len(arguments) < 2:
        return locations.USUAL
    return AMOUNTS[arguments[1]] if arguments[1] in AMOUNTS else length(arguments[1])


def _side(name: str, arguments: Sequence[str]) -> Place:
    _, du, dv = locations.SIDES[name]
    return Place(*locations.beside(_letter(arguments[0]), du, dv, _amount(arguments)))


def _beside(name: str, arguments: Sequence[str]) -> Place:
    del name
    letter, size = _letter(arguments[0]), _amount(arguments)
    if letter != "a":
        return Place(*locations.beside(letter, 1, 0, size))
    # There is more room towards the middle of the picture.
    scenes = ("A left", "A middle", "A right")
    points = tuple(
        locations.beside("a", -1 if scene == "A right" else 1, 0, size) for scene in scenes
    )
    return Place("", "", scenes, points)


def _edge(name: str, arguments: Sequence[str]) -> Place:
    del name
    return Place(*locations.inside(_letter(arguments[0]), *CORNERS[arguments[1]]))


def _corner(name: str, arguments: Sequence[str]) -> Place:
    """Take the corner that is farthest from the robot, or nearest: it stands below the middle."""
    letter, dv = _letter(arguments[0]), -1 if name == "farcorner" else 1
    points = tuple(locations.inside(letter, du, dv) for du in (dv, -dv))
    return Place("", "", ("A left", "A right"), points)


def _between(name: str, arguments: Sequence[str]) -> Place:
    del name
    if [_letter(argument) for argument in arguments] != ["a", "b"]:
        raise ValueError(arguments)
    boxes = locations.BOXES_OF_BETWEEN
    return Place("", "", tuple(boxes), tuple(boxes.values()))


def _by_another(name: str, arguments: Sequence[str]) -> Place:
    """Take the side or the end of A where B is, or the other."""
    if [_letter(argument) for argument in arguments] != ["a", "b"]:
        raise ValueError(arguments)
    sign = -1 if name.startswith("other") else 1
    ways = [(sign * du, sign * dv) for du, dv in locations.WAY_TO_B.values()]
    if name.endswith("end"):
        points = tuple(locations.inside("a", du, dv) for du, dv in ways)
    else:
        points = tuple(locations.beside("a", du, dv, locations.USUAL) for du, dv in ways)
    return Place("", "", tuple(locations.WAY_TO_B), points)


def _off_both(name: str, arguments: Sequence[str]) -> Place:
    """Go between two that stand side by side, and from there to the back or to the front."""
    if [_letter(argument) for argument in arguments] != ["a", "b"]:
        raise ValueError(arguments)
    _, du, dv = locations.SIDES[name.removesuffix("both")]
    y = locations.beside("a", du, dv, locations.USUAL)[1]
    scenes = ("A left of B", "A right of B")
    points = tuple((locations.BOXES_OF_BETWEEN[scene][0], y) for scene in scenes)
    return Place("", "", scenes, points)


def _along(name: str, arguments: Sequence[str]) -> Place:
    share = "0.25" if name == "nearer" else arguments[2]
    float(share)
    a, b = _letter(arguments[0]), _letter(arguments[1])
    return Place(f"{a}.u+{share}*({b}.u-{a}.u)", f"{a}.v+{share}*({b}.v-{a}.v)")


def _middle(name: str, arguments: Sequence[str]) -> Place:
    del name
    letters = [_letter(argument) for argument in arguments]
    count = len(letters)
    x, y = ("+".join(f"{letter}.{axis}" for letter in letters) for axis in "uv")
    return Place(f"({x})/{count}", f"({y})/{count}")


def _diagonal(name: str, arguments: Sequence[str]) -> Place:
    del name
    first, second = locations.SIDES[arguments[1]], locations.SIDES[arguments[2]]
    du, dv = first[1] + second[1], first[2] + second[2]
    if not (du and dv):
        raise ValueError(arguments)
    return Place(*locations.beside(_letter(arguments[0]), du, dv, _amount(arguments[2:])))


def _cross(name: str, arguments: Sequence[str]) -> Place:
    """Take u from the first place, v from the second, or the height of an object."""
    across = read_place(arguments[0])
    if name == "level":
        return Place(across.x, f"{_letter(arguments[1])}.v")
    return Place(across.x, read_place(arguments[1]).y)


_READERS: dict[str, Callable[[str, Sequence[str]], Place]] = {
    **dict.fromkeys(locations.SIDES, _side),
    "beside": _beside,
    "edge": _edge,
    "between": _between,
    **dict.fromkeys(("side", "otherside", "end", "otherend"), _by_another),
    **dict.fromkeys(("behindboth", "frontboth"), _off_both),
    "nearer": _along,
    "along": _along,
    "middle": _middle,
    "diagonal": _diagonal,
    "cross": _cross,
    "level": _cross,
    "farcorner": _corner,
    "nearcorner": _corner,
}
