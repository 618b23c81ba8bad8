"""Every format in which models write places: what is written is read, and no text breaks it."""

import json
import math
import time
from collections.abc import Callable
from contextlib import suppress

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from w2c.errors import ModelError
from w2c_grounding.pointer.formats import PARSERS
from w2c_grounding.pointer.reading import MAX_PLACES, MAX_TEXT, denies, read_answer

Numbers = tuple[float, ...]

# Three decimals, as models write them; text and number are then the same.
NUMBER = st.integers(0, 999_999).map(lambda value: value / 1000)
POINTS = st.lists(st.tuples(NUMBER, NUMBER), min_size=1, max_size=5)
BOXES = st.lists(st.tuples(NUMBER, NUMBER, NUMBER, NUMBER), min_size=1, max_size=5)
WHOLE = st.lists(st.tuples(*[st.integers(0, 999)] * 2), min_size=1, max_size=5)


def read(name: str, text: str) -> list[Numbers]:
    return [place.numbers for place in PARSERS[name](text)]


def molmo_tags(points: list[Numbers]) -> str:
    return " and ".join(f'<point x="{x}" y="{y}" alt="a cup">a cup</point>' for x, y in points)


def molmo_one_tag(points: list[Numbers]) -> str:
    pairs = " ".join(f'x{n}="{x}" y{n}="{y}"' for n, (x, y) in enumerate(points, 1))
    return f'Here: <points {pairs} alt="cups">cups</points>.'


def molmo_coordinates(points: list[Numbers]) -> str:
    triples = " ".join(f"{n} {x:.0f} {y:.0f}" for n, (x, y) in enumerate(points, 1))
    return f'<points coords="1 {triples}">cups</points>'


def qwen_points(points: list[Numbers]) -> str:
    return f"```json\n{json.dumps([{'point_2d': p, 'label': 'cup'} for p in points])}\n```"


def qwen_boxes(boxes: list[Numbers]) -> str:
    return f"Sure!\n{json.dumps([{'bbox_2d': box, 'label': 'a [1] cup'} for box in boxes])}"


def x_and_y(points: list[Numbers]) -> str:
    return json.dumps({"points": [{"x": x, "y": y} for x, y in points]})


def corners(boxes: list[Numbers]) -> str:
    return json.dumps([dict(zip(("x1", "y1", "x2", "y2"), box, strict=True)) for box in boxes])


def box_tags(boxes: list[Numbers]) -> str:
    return "".join(f"<ref>cup</ref><box>({a}, {b}),({c}, {d})</box>" for a, b, c, d in boxes)


def box_tokens(boxes: list[Numbers]) -> str:
    return "".join(f"<|box_start|>({a},{b}),({c},{d})<|box_end|>" for a, b, c, d in boxes)


def point_list_tag(points: list[Numbers]) -> str:
    return f"<think>where?</think><answer><point>{json.dumps(points)}</point></answer>"


def prose(places: list[Numbers]) -> str:
    return "It is at " + ", ".join(f"({', '.join(map(str, p))})" for p in places) + ", I think."


@pytest.mark.parametrize(
    ("name", "write"),
    [
        ("molmo", molmo_tags),
        ("molmo", molmo_one_tag),
        ("json", qwen_points),
        ("json", x_and_y),
        ("json", json.dumps),
        ("tagged", point_list_tag),
        ("tuples", prose),
    ],
)
@given(points=POINTS)
@settings(max_examples=25)
def test_points_are_read_as_they_were_written(
    name: str, write: Callable[[list[Numbers]], str], points: list[Numbers]
) -> None:
    assert read(name, write(points)) == points
    assert [place.numbers for place in read_answer(write(points)).places] == points


@pytest.mark.parametrize(
    ("name", "write"),
    [
        ("json", qwen_boxes),
        ("json", corners),
        ("tagged", box_tags),
        ("tagged", box_tokens),
        ("tuples", prose),
    ],
)
@given(boxes=BOXES)
@settings(max_examples=25)
def test_boxes_are_read_as_they_were_written(
    name: str, write: Callable[[list[Numbers]], str], boxes: list[Numbers]
) -> None:
    assert read(name, write(boxes)) == boxes
    assert [place.numbers for place in read_answer(write(boxes)).places] == boxes


@given(points=WHOLE)
@settings(max_examples=25)
def test_formats_that_fix_order_and_scale_say_so(points: list[tuple[int, int]]) -> None:
    expected: list[Numbers] = [(float(x), float(y)) for x, y in points]
    for name, text, scale in (
        ("molmo", molmo_coordinates(expected), 1000.0),
        ("molmo", molmo_tags(expected), 100.0),
        ("json", json.dumps([{"point": [y, x], "label": "cup"} for x, y in points]), 1000.0),
    ):
        places = PARSERS[name](text)
        assert [place.numbers for place in places] == expected
        assert {place.scale for place in places} == {scale}
    tokens = "".join(f"<loc{y:04d}><loc{x:04d}><loc{y:04d}><loc{x:04d}> cup" for x, y in points)
    assert read("locations", tokens) == [(x, y, x, y) for x, y in points]
    boxes = json.dumps([{"box_2d": [y, x, y, x]} for x, y in points])
    assert read("json", boxes) == [(x, y, x, y) for x, y in points]


PIECES = [
    "<point ", "<points ", "</point>", "<box>", "</box>", 'coords="', "x1=", 'y="', "<loc0001>",
    "[", "]", "(", ")", "{", "}", '"point_2d":', '"x":', ",", " ", "<|box_start|>", "<|box_end|>",
    "NaN", "Infinity", "1e999", "-", ".", "12", "0.5", "9" * 30, "true", "null", "none", "\u0661",
]  # fmt: skip


@given(
    st.one_of(st.text(max_size=200), st.lists(st.sampled_from(PIECES), max_size=60).map("".join))
)
@settings(max_examples=150)
def test_no_text_breaks_a_parser(text: str) -> None:
    for parser in PARSERS.values():
        for place in parser(text):
            assert len(place.numbers) in (2, 4)
            assert all(isinstance(number, float) for number in place.numbers)
    with suppress(ModelError):  # the only error there is
        assert len(read_answer(text).places) <= MAX_PLACES


@pytest.mark.parametrize(
    "piece", ["<point x=", "[", "(1,", '{"a":', "<box>", "coords='", "1.1", "[1"]
)
def test_a_long_hostile_answer_is_read_in_no_time(piece: str) -> None:
    text = (piece * MAX_TEXT)[:MAX_TEXT]
    started = time.process_time()
    for parser in PARSERS.values():
        parser(text)
    assert time.process_time() - started < 2.0, "a quadratic pattern would take minutes"


def test_numbers_that_are_no_coordinates_are_not_cut_into_some() -> None:
    assert read("tuples", "(123456789, 5)") == []
    assert read("tuples", "(1e5, 5)") == []
    assert read("tagged", "<point>(1234567890, 5, 7)</point>") == [(5.0, 7.0)]
    assert math.isnan(read("json", '[{"point_2d": [NaN, 5]}]')[0][0]), "dropped by who knows sizes"


@pytest.mark.parametrize(
    "text",
    ["[]", "none", "null", '{"points": []}', "There are none.", "```json\n[]\n```", "Not found.",
     "I can't see a cup.", "I can\u2019t see a cup.", "There is no cup in the picture.",
     '[{"point_2d": null, "label": "cup"}]', '{"found": false}'],
)  # fmt: skip
def test_that_nothing_is_there_is_an_answer(text: str) -> None:
    assert read_answer(text).places == ()


@pytest.mark.parametrize(
    "text", ["", "A cup is a small bowl.", "5", "[1, 2, 3]", "<html>busy</html>", "no " * 200]
)
def test_what_names_no_place_and_denies_none_is_an_error(text: str) -> None:
    assert not denies(text)
    with pytest.raises(ModelError, match="names no place"):
        read_answer(text)


def test_an_answer_that_is_too_long_is_refused_and_too_many_places_are_cut() -> None:
    with pytest.raises(ModelError, match=f"limit {MAX_TEXT}"):
        read_answer("(1, 2)" * MAX_TEXT)
    reading = read_answer(json.dumps([[n, n] for n in range(MAX_PLACES + 7)]))
    assert len(reading.places) == MAX_PLACES
    assert reading.dropped == 7


def test_only_the_expected_format_is_read() -> None:
    text = '<point x="50" y="50">(1, 2)</point>'
    assert read_answer(text).places[0].numbers == (50.0, 50.0)
    assert read_answer(text, "tuples").places[0].numbers == (1.0, 2.0)
