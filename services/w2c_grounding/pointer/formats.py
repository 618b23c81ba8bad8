"""The formats in which models write places. Each parser is a pure function: text -> places.

A parser returns nothing for a text that is not in its format. The text is a stranger's: patterns
have no nested repetition, and numbers a bounded length.
"""

import json
import re
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from w2c.chat_server import extract_json
from w2c_grounding.pointer.places import Place

# Longer ones and powers of ten are no coordinates: they match as a whole or not at all.
_NUMBER = r"(?<![\w.])[-+]?(?:\d{1,6}(?:\.\d{0,9})?|\.\d{1,9})(?![\d.]|[eE][-+]?\d)"
_FOUND_NUMBER = re.compile(_NUMBER)
_POINT_TAG = re.compile(r"<points?\s([^<>]{1,4000})>")
_ATTRIBUTE = re.compile(rf"\b([xy])(\d{{0,4}})\s{{0,3}}=\s{{0,3}}[\"']?({_NUMBER})")
_COORDINATES = re.compile(r"\bcoords\s{0,3}=\s{0,3}[\"']([^\"']{1,4000})[\"']")
_LOCATIONS = re.compile(r"<loc(\d{4})><loc(\d{4})><loc(\d{4})><loc(\d{4})>")
_TAGGED = re.compile(
    r"<(?P<tag>box|bbox|point)>(?P<body>[^<>]{1,4000})</(?P=tag)>"
    r"|<\|(?P<start>box|point)_start\|>(?P<inside>[^<>]{1,4000})<\|(?P=start)_end\|>"
)
_TUPLE = re.compile(
    rf"[\[(]\s{{0,5}}({_NUMBER})\s{{0,5}},\s{{0,5}}({_NUMBER})\s{{0,5}}"
    rf"(?:,\s{{0,5}}({_NUMBER})\s{{0,5}},\s{{0,5}}({_NUMBER})\s{{0,5}})?[\])]"
)
_DEEPEST = 6
"""Of lists and objects in JSON; deeper ones hold no places"""

_X_FIRST = ("point_2d", "bbox_2d", "bbox", "box", "points", "coordinates", "position")
_Y_FIRST = ("point", "box_2d")
"""As Gemini writes them, always from 0 to 1000"""


def molmo(text: str) -> list[Place]:
    """Read Molmo's XML: `<point x="61.5" y="40.6">`, `<points x1= y1= x2= y2=>`, `coords="..."`.

    x and y are percents. `coords`, of its second generation, is from 0 to 1000: groups of a
    picture's number and then a point's number, x and y for each point; or pairs alone.
    """
    places: list[Place] = []
    for attributes in _POINT_TAG.findall(text):
        found: dict[str, dict[str, float]] = {}
        for axis, number, value in _ATTRIBUTE.findall(attributes):
            found.setdefault(number, {})[axis] = float(value)
        places += [
            Place((pair["x"], pair["y"]), 100.0) for pair in found.values() if len(pair) == 2
        ]
        for coordinates in _COORDINATES.findall(attributes):
            for group in re.split(r"[\t:;,]", coordinates):
                places += _molmo_group([float(value) for value in _FOUND_NUMBER.findall(group)])
    return places


def _molmo_group(numbers: Sequence[float]) -> list[Place]:
    if len(numbers) % 3 == 1:
        numbers = [value for index, value in enumerate(numbers[1:]) if index % 3]
    return _grouped(numbers, 2, 1000.0)


def locations(text: str) -> list[Place]:
    """Read PaliGemma's tokens: `<loc0256><loc0128><loc0512><loc0384> cup`, y before x, of 1024."""
    places = []
    for found in _LOCATIONS.findall(text):
        top, left, bottom, right = (float(value) for value in found)
        places.append(Place((left, top, right, bottom), 1024.0))
    return places


def tagged(text: str) -> list[Place]:
    """Read numbers in tags: `<box>(1,2),(3,4)</box>`, `<point>[[1, 2]]</point>`, Qwen2-VL's."""
    places: list[Place] = []
    for match in _TAGGED.finditer(text):
        kind = match["tag"] or match["start"]
        body = match["body"] or match["inside"]
        numbers = [float(value) for value in _FOUND_NUMBER.findall(body)]
        places += _grouped(numbers, 2 if kind == "point" else 4)
    return places


def json_values(text: str) -> list[Place]:
    """Read JSON, also within prose: `[{"point_2d": [x, y]}]`, `bbox_2d`, `{"x": 1, "y": 2}`, lists.

    `point` and `box_2d` are Gemini's: y before x, from 0 to 1000.
    """
    try:
        value = json.loads(extract_json(text), parse_int=float)
    except (ValueError, RecursionError):
        return []
    return list(_places_in(value, _DEEPEST))


def tuples(text: str) -> list[Place]:
    """Read bare tuples in prose, as RoboPoint writes them: `[(0.46, 0.53), (0.48, 0.52)]`."""
    return [
        Place(tuple(float(value) for value in found if value)) for found in _TUPLE.findall(text)
    ]


PARSERS: dict[str, Callable[[str], list[Place]]] = {
    "molmo": molmo,
    "locations": locations,
    "tagged": tagged,
    "json": json_values,
    "tuples": tuples,
}
"""The most particular format first: each is also text that a later one could misread."""


def _grouped(numbers: Sequence[float], size: int, scale: float | None = None) -> list[Place]:
    """Return places of so many numbers each; a rest that is no whole place is left out."""
    whole = len(numbers) - len(numbers) % size
    return [Place(tuple(numbers[at : at + size]), scale) for at in range(0, whole, size)]


def _places_in(value: Any, depth: int) -> Iterator[Place]:
    """Yield the places of a decoded JSON value."""
    if depth == 0:
        return
    if isinstance(value, list):
        numbers = _numbers(value)
        if numbers is not None and len(numbers) in (2, 4):
            yield Place(numbers)
        elif numbers is None:
            for item in value:
                yield from _places_in(item, depth - 1)
    elif isinstance(value, dict):
        corners = _numbers([value.get(name) for name in ("x", "y")]) or _numbers(
            [value.get(name) for name in ("x1", "y1", "x2", "y2")]
        )
        if corners is not None:
            yield Place(corners)
            return
        for name, inner in value.items():
            numbers = _numbers(inner) if isinstance(inner, list) else None
            if name in _Y_FIRST and numbers is not None and len(numbers) in (2, 4):
                yield Place(_x_first(numbers), 1000.0)
            elif name in _X_FIRST or isinstance(inner, list | dict):
                yield from _places_in(inner, depth - 1)


def _x_first(numbers: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(numbers[index ^ 1] for index in range(len(numbers)))


def _numbers(values: list[Any]) -> tuple[float, ...] | None:
    """Return the values where each is a number, else None. NaN is one: it is dropped later."""
    # All of them are floats: `parse_int` made them so, and JSON's true is no float.
    return tuple(values) if values and all(isinstance(value, float) for value in values) else None
