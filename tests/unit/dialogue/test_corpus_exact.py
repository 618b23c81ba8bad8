"""How far, which part, which hand, which thing: the corpus means what such words say."""

import re
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from w2c.messages import Box
from w2c_dialogue.corpus import (
    corrections,
    instructions,
    limbs,
    locations,
    measures,
    relations,
    written,
    written_lines,
)
from w2c_dialogue.corpus.asides import ASIDES, with_aside
from w2c_dialogue.corpus.clauses import one_phrase, same_kind, use_phrase, what_phrase
from w2c_dialogue.corpus.draft import Draft
from w2c_dialogue.corpus.draw import Draw
from w2c_dialogue.corpus.exact_moves import (
    along_axis,
    along_last,
    earlier_move,
    towards,
    two_amounts,
    two_lengths,
)
from w2c_dialogue.corpus.fitting import says_number
from w2c_dialogue.corpus.limbs import by_the_other
from w2c_dialogue.corpus.measures import body_length, repaired
from w2c_dialogue.corpus.places import read_place
from w2c_dialogue.corpus.steering import Correction
from w2c_dialogue.expressions import correction_symbols, evaluate, object_symbols
from w2c_dialogue.prompts.base import CorrectionScene, Move, SceneObject
from w2c_dialogue.prompts.limb_words import named_limb
from w2c_dialogue.prompts.spans import naming_spans
from w2c_dialogue.utterance import Span, parse

SCENE = CorrectionScene((640, 360), (640, 360), (), (), (), 10.0)
CENTIMETRES = {
    "finger": 2.0, "thumb": 2.5, "hand": 9.0, "palm": 9.0, "foot": 30.0, "feet": 30.0, "arm": 60.0,
}  # fmt: skip
COUNTS = {
    "two": 2, "2": 2, "couple": 2, "three": 3, "3": 3, "four": 4, "4": 4, "five": 5, "half": 0.5,
}  # fmt: skip


def draw(seed: int = 0) -> Draw:
    return Draw(np.random.default_rng(seed), held_out=False)


def test_lengths_by_the_body_are_those_of_the_documentation() -> None:
    source, seen = draw(), Counter[str]()
    for _ in range(500):
        said, expression = body_length(source)
        (part,) = {part for part in CENTIMETRES if re.search(rf"\b{part}", said)}
        factors = [COUNTS[word] for word in said.split() if word in COUNTS]
        count = 1.5 if "and a half" in said else factors[0] if factors else 1.0
        assert evaluate(expression, {"cm": 10.0}) == pytest.approx(10 * count * CENTIMETRES[part])
        seen[part] += 1

    assert set(seen) == set(CENTIMETRES)


@pytest.mark.parametrize("text", ["a finger to the left", "up a thumb's width", "two hands left"])
def test_a_point_said_by_the_body_is_not_explained_by_steps(text: str) -> None:
    assert says_number(parse(text))


def test_of_a_repaired_number_the_last_is_meant() -> None:
    assert repaired("three", "four", draw()).split()[-1] == "four"
    source, found = draw(), 0
    for _ in range(3000):
        said, expression = measures.distance(source)
        numbers = [word for word in re.findall(r"[0-9.]+|[a-z]+", said) if word.isdigit()]
        if len(numbers) == 2 and re.search(r"\b(no|sorry|mean|rather|er)\b", said):
            assert numbers[1] in re.split(r"[*]", expression)
            found += 1
    assert found > 20


def test_two_amounts_belong_to_their_directions() -> None:
    source, seen = draw(1), 0
    amount = re.compile(
        r"\b(left|right|up|down) a (lot|tad)\b|\ba (lot|tad) (left|right|up|down)\b"
    )
    for _ in range(800):
        made = two_amounts(source)
        symbols = correction_symbols(SCENE)
        du, dv = abs(evaluate(made.x, symbols) - 640), abs(evaluate(made.y, symbols) - 360)
        assert du
        assert dv
        for before, size, other, after in amount.findall(" ".join(made.draft.words)):
            along = du if (before or after) in ("left", "right") else dv
            assert along == {"lot": 100, "tad": 10}[size or other]
            seen += 1
    assert seen > 5


def test_a_length_by_the_body_goes_in_the_direction_that_is_said() -> None:
    source, seen = draw(), 0
    for _ in range(200):
        made = corrections._by_body(source)
        symbols = correction_symbols(SCENE)
        text = " ".join(made.draft.words)
        found = re.search(r"two fingers.* (left|right|up|down)(wards)?\b", text)
        if found is None or re.search(r"move your (left|right) hand", text):
            continue
        way = {"left": (-40, 0), "right": (40, 0), "up": (0, -40), "down": (0, 40)}[found[1]]
        moved = evaluate(made.x, symbols) - 640, evaluate(made.y, symbols) - 360
        assert moved == pytest.approx(way)
        seen += 1
    assert seen


def test_left_and_right_edges_are_named_as_often_as_near_and_far_ones() -> None:
    source = draw()
    places = Counter(locations._edge(source).x for _ in range(2000))

    assert places["a.left+0.15*a.width"] > 600
    assert places["a.right-0.15*a.width"] > 600


@pytest.mark.parametrize(
    ("note", "scene", "corner"),
    [
        ("farcorner(A)", "A left", (115, 215)),
        ("farcorner(A)", "A right", (185, 215)),
        ("nearcorner(A)", "A left", (185, 285)),
        ("nearcorner(A)", "A right", (115, 285)),
    ],
)
def test_far_and_near_corners_are_those_of_a_robot_below_the_picture(
    note: str, scene: str, corner: tuple[float, float]
) -> None:
    place = read_place(note)
    x, y = place.by_scene[place.scenes.index(scene)]
    symbols = object_symbols([Box(left=100, top=200, right=200, bottom=300, score=1.0)], 10.0)

    assert (evaluate(x, symbols), evaluate(y, symbols)) == pytest.approx(corner)


@pytest.mark.parametrize("make", [use_phrase, what_phrase, one_phrase])
def test_a_clause_may_be_named_as_a_whole(make: object) -> None:
    assert callable(make)
    source = draw()
    for _ in range(300):
        utterance = parse(make(source))
        assert Span(1, len(utterance.folded)) in naming_spans(utterance), utterance.text


def test_things_of_written_lines_stay_of_their_kind() -> None:
    source = draw()
    assert same_kind("what keeps the door open", source).startswith("what")
    assert len(same_kind("thing you hang coats on", source).split()) > 2
    assert same_kind("blue one", source).endswith(" one")
    assert same_kind("blue mug", source) == ""
    (line,) = written_lines.read_line(
        "instructions", "absolute unspecified reach | take [what keeps the door open]"
    )
    for seed in range(20):
        utterance, (span,) = written.instruction_of(line, draw(seed)).draft.finish()
        assert utterance.folded[1].startswith("what")
        assert span == Span(2, len(utterance.folded))


def test_asides_are_no_part_of_a_name() -> None:
    said = 0
    for seed in range(200):
        template = with_aside("behind the {A} please", draw(seed))
        draft = Draft()
        draft.fill(template, {"A": "snare drum"})
        utterance, (span,) = draft.finish()
        assert utterance.phrase(span) == "snare drum"
        assert draft.words[-1] == "please"
        said += any(aside in template for aside in ASIDES)
    assert said
    assert with_aside("the {A}'s lid", draw()) == "the {A}'s lid"


def test_another_thing_is_a_new_target_and_what_is_rejected_is_none() -> None:
    source = draw()
    for _ in range(200):
        made = instructions._other_thing(source)
        utterance, spans = made.draft.finish()
        assert made.position == "absolute"
        assert len(spans) == 1
        assert spans[0] in naming_spans(utterance)
        assert utterance.phrase(spans[0]) not in ("this one", "that one", "wrong one")


def test_of_a_repaired_limb_the_one_that_is_meant_counts() -> None:
    source, seen = draw(), set()
    for _ in range(500):
        said, name = limbs._short_limb(source, feet=True)
        words = re.findall(r"[a-z]+", said.lower())
        letters = {"l": "left", "r": "right", "lh": "left", "rh": "right", "lf": "left"}
        sides = [letters.get(word, word) for word in words]
        sides = ["right" if side == "rf" else side for side in sides]
        sides = [side for side in sides if side in ("left", "right")]
        meant = sides[-1]
        if "other" in words:
            meant = "left" if meant == "right" else "right"
        assert name.startswith(meant), said
        seen.add(name)
    assert seen == {"left_hand", "right_hand", "left_foot", "right_foot"}


@pytest.mark.parametrize("unit_again", [True, False])
def test_each_length_goes_in_the_direction_that_is_said_beside_it(*, unit_again: bool) -> None:
    source, seen = draw(2), 0
    way = r"(?:to the )?(left|right|up|down)"
    other = r"([0-9]+) (?:px|pixels?)" if unit_again else "([0-9]+)"
    pair = re.compile(
        rf"\b([0-9]+) (?:px|pixels?) {way},? (?:and|then|plus|with|&|and just) {other} {way}\b"
    )
    for _ in range(20_000):
        made = two_lengths(source)
        found = pair.search(" ".join(made.draft.words))
        if found is None:
            continue
        along = {found[2]: float(found[1]), found[4]: float(found[3])}
        symbols = correction_symbols(SCENE)
        moved = evaluate(made.x, symbols) - 640, evaluate(made.y, symbols) - 360
        assert moved[0] == along.get("right", 0) - along.get("left", 0)
        assert moved[1] == along.get("down", 0) - along.get("up", 0)
        seen += 1
    assert seen


def test_a_length_is_measured_along_the_line_to_the_thing() -> None:
    """The thing is at (100, 200) to (200, 300), the target 490 px right and 110 px below of it."""
    source = draw(3)
    box = Box(left=100, top=200, right=200, bottom=300, score=1.0)
    scene = replace(SCENE, objects=(SceneObject("cup", box),))
    symbols = correction_symbols(scene)
    line = np.array([150.0 - 640.0, 250.0 - 360.0])
    signs = Counter[bool]()
    for _ in range(200):
        made = towards(source, "the {A}", {"A": "cup"})
        moved = np.array([evaluate(made.x, symbols) - 640, evaluate(made.y, symbols) - 360])
        cosine = moved @ line / np.linalg.norm(moved) / np.linalg.norm(line)
        away = re.search(r"\b(away|farther|further|back from|off|clear of|out from)\b", said(made))
        assert cosine == pytest.approx(-1.0 if away else 1.0)
        signs[bool(away)] += 1
    assert min(signs.values()) > 30


def test_a_length_back_is_measured_along_the_last_move() -> None:
    source = draw(4)
    symbols = correction_symbols(replace(SCENE, moves=(Move(0.0, 50.0), Move(-30.0, -40.0))))
    signs = Counter[bool]()
    for _ in range(300):
        made = along_last(source)
        moved = np.array([evaluate(made.x, symbols) - 640, evaluate(made.y, symbols) - 360])
        along = moved @ np.array([-0.6, -0.8])
        assert abs(along) == pytest.approx(np.linalg.norm(moved))
        back = re.search(r"\b(back|return|undo|past|too|over|less|off)", said(made))
        assert (along < 0) == bool(back), said(made)
        assert made.needs_past == 1
        signs[bool(back)] += 1
    assert min(signs.values()) > 50


def test_an_earlier_move_is_named_by_its_place() -> None:
    source = draw(5)
    moves = (Move(0.0, 50.0), Move(20.0, 0.0), Move(-30.0, -40.0))
    symbols = correction_symbols(replace(SCENE, moves=moves))
    seen = set()
    for _ in range(200):
        made = earlier_move(source)
        moved = evaluate(made.x, symbols) - 640, evaluate(made.y, symbols) - 360
        first = re.search(r"\bfirst\b", said(made)) is not None
        assert moved in (((0, 50), (0, -50)) if first else ((20, 0), (-20, 0)))
        seen.add(moved)
    assert len(seen) == 4


def test_minus_along_an_axis_is_to_the_left_or_up() -> None:
    source, symbols = draw(6), correction_symbols(SCENE)
    seen = Counter[tuple[float, float]]()
    for _ in range(300):
        made = along_axis(source)
        moved = evaluate(made.x, symbols) - 640, evaluate(made.y, symbols) - 360
        minus = re.search(r"minus|-|subtract|decrease|negative|less|off|reduce", said(made))
        vertical = re.search(r"\b([vy]|vertical)\b", said(made))
        assert (np.sign(sum(moved)) < 0) == bool(minus), said(made)
        assert bool(moved[1]) == bool(vertical), said(made)
        seen[np.sign(moved[0]), np.sign(moved[1])] += 1
    assert len(seen) == 4


@pytest.mark.parametrize(
    ("note", "scene", "point"),
    [
        ("side(A,B)", "A left of B", (220, 250)),
        ("otherside(A,B)", "A left of B", (80, 250)),
        ("side(A,B)", "A above B", (150, 320)),
        ("end(A,B)", "A right of B", (115, 250)),
        ("otherend(A,B)", "A below B", (150, 285)),
        ("behindboth(A,B)", "A left of B", (350, 180)),
        ("frontboth(A,B)", "A left of B", (350, 320)),
    ],
)
def test_a_place_by_two_things_follows_how_they_stand(
    note: str, scene: str, point: tuple[float, float]
) -> None:
    place = read_place(note)
    x, y = place.by_scene[place.scenes.index(scene)]
    boxes = [Box(left=at, top=200, right=at + 100, bottom=300, score=1.0) for at in (100, 500)]
    symbols = object_symbols(boxes, 10.0)

    assert (evaluate(x, symbols), evaluate(y, symbols)) == pytest.approx(point)


def test_drawn_places_by_two_things_mean_what_written_ones_mean() -> None:
    source, seen = draw(7), Counter[str]()
    for kind in ("side", "end") * 200:
        make = relations._side_by_another if kind == "side" else relations._end_by_another
        place = make(source)
        away = re.search(
            r"away|opposite|is not|not on|\bfar\b|other side|f[ua]rth|past|across", place.text
        )
        note = f"{'other' * bool(away)}{kind}"
        wanted = read_place(f"{note}(A,B)")
        assert (place.x, place.y) == wanted.by_scene[wanted.scenes.index(place.scene)], place
        seen[note] += 1
    assert min(seen[kind] for kind in ("side", "otherside", "end", "otherend")) > 20


def said(made: Correction) -> str:
    return " ".join(made.draft.words)


def test_a_limb_that_is_told_by_the_other_one_is_not_the_one_that_is_named() -> None:
    source, seen = draw(8), Counter[str]()
    for _ in range(300):
        text, limb = by_the_other(source, "lean on the {A}", feet=True)
        sides = set(re.findall(r"\b(left|right)\b", text))
        side, part = limb.split("_")
        assert part in text
        assert "{A}" in text
        assert sides == {"left", "right"} or side not in sides, text
        assert named_limb(parse(text.replace("{A}", "box"))) in (None, limb), text
        seen[limb] += 1
    assert set(seen) == {"left_hand", "right_hand", "left_foot", "right_foot"}


def test_what_is_not_meant_and_where_a_thing_stands_are_no_objects() -> None:
    source = draw(9)
    things = Counter[bool]()
    for _ in range(2000):
        made = instructions.instruction(source, "absolute", plain=True)
        utterance, spans = made.draft.finish()
        assert len(spans) == 1, utterance.text
        after = utterance.folded[spans[0][1] :]
        things["standing" in after or "lying" in after or "instead" in after] += 1
    assert things[True] > 20
