"""How far, which part, which hand, which thing: the corpus means what such words say."""

import re
from collections import Counter

import numpy as np
import pytest

from w2c.messages import Box
from w2c_dialogue.corpus import (
    corrections,
    instructions,
    limbs,
    locations,
    measures,
    written,
    written_lines,
)
from w2c_dialogue.corpus.asides import ASIDES, with_aside
from w2c_dialogue.corpus.clauses import one_phrase, same_kind, use_phrase, what_phrase
from w2c_dialogue.corpus.draft import Draft
from w2c_dialogue.corpus.draw import Draw
from w2c_dialogue.corpus.exact_moves import (
    two_amounts,
)
from w2c_dialogue.corpus.fitting import says_number
from w2c_dialogue.corpus.measures import body_length, repaired
from w2c_dialogue.corpus.places import read_place
from w2c_dialogue.expressions import correction_symbols, evaluate, object_symbols
from w2c_dialogue.prompts.base import CorrectionScene
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
