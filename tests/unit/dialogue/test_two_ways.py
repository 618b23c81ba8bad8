"""Corrections by two amounts are asked one by one."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fakes.dialogue_world import ScriptedModel
from w2c_dialogue.corrector import corrected_point
from w2c_dialogue.prompts.base import CorrectionScene
from w2c_dialogue.prompts.sets import PROMPT_SETS
from w2c_dialogue.prompts.two_ways import parts
from w2c_dialogue.utterance import parse

SCENE = CorrectionScene((640.0, 360.0), (640.0, 360.0), (), (), (), 10.0)
SIZE = (1280, 720)


def said(text: str) -> list[str]:
    return [part.folded_text for part in parts(parse(text))]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("Down two cm, then left three cm.", ["down two cm", "left three cm"]),
        ("ten pixels up, five over to the left", ["ten pixels up", "five pixels over to the left"]),
        ("3 cm up, 7 left.", ["3 cm up", "7 cm left"]),
        ("2cm lower n 3 to the left", ["2cm lower", "3 cm to the left"]),
        ("two down and 3 mm right please", ["two mm down", "3 mm right please"]),
        ("a lot left and a touch up", ["a lot left", "a touch up"]),
        ("left and slightly down", ["left", "slightly down"]),
        ("no, a tad lower & half a cm right", ["no, a tad lower", "half a cm right"]),
        ("a lil lower n exactly 2cm left", ["a lil lower", "exactly 2cm left"]),
        ("up 3 steps and two to the right", ["up 3 steps", "two steps to the right"]),
        ("a bit up, 2 px left", ["a bit up", "2 px left"]),
        ("Add +35 px in u and -20 px in v.", ["add +35 px in u", "-20 px in v"]),
        ("+3 cm in u and -2 in v", ["+3 cm in u", "-2 cm in v"]),
        ("u plus 20, v minus 5", ["u plus 20", "v minus 5"]),
        ("3 cm left and 2,5 up", ["3 cm left", "2,5 cm up"]),
        ("3 m left and two up", ["3 m left", "two m up"]),
        ("can u go 3 cm up and 2 left", ["can u go 3 cm up", "2 cm left"]),
    ],
)
def test_each_part_has_its_direction_and_amount(text: str, expected: list[str]) -> None:
    assert said(text) == expected


@pytest.mark.parametrize(
    "text",
    [
        pytest.param("a bit up and left", id="one amount, said first, for both"),
        pytest.param("up and left", id="no amount"),
        pytest.param("up and to the left, 2 cm each", id="one for each"),
        pytest.param("2 cm up and 3 cm higher", id="one axis"),
        pytest.param("3 cm left", id="one way"),
        pytest.param("left, no right, and up 2 cm", id="taken back"),
        pytest.param("right, a bit up", id="an interjection"),
        pytest.param("two cm left and one and a half up", id="a joint too many"),
        pytest.param("2 cm left 3 cm up", id="no joint"),
        pytest.param("20 px in u", id="one axis of the picture"),
        pytest.param("can u just go 20 px along v", id="u is who is asked"),
        pytest.param("left 2 cm and then up as before", id="an earlier move"),
        pytest.param("too far left and 2 cm too low, so up", id="a complaint"),
    ],
)
def test_all_else_is_asked_at_once(text: str) -> None:
    utterance = parse(text)
    assert parts(utterance) == (utterance,)


@given(st.text(alphabet="23 ,.abcdefghilmnoprtuwx", max_size=80))
def test_no_word_is_lost_but_joints(text: str) -> None:
    words = parse(f"x {text} left 2 cm and up").folded
    cut = parts(parse(f"x {text} left 2 cm and up"))
    kept = [word for part in cut for word in part.folded]
    assert [word for word in words if word in kept or word == "and"] == list(words)


def test_the_moves_add_up() -> None:
    model = ScriptedModel(
        correct=[
            {"x": "target.u-3*cm", "y": "target.v"},
            {"x": "target.u", "y": "target.v+2*cm"},
        ]
    )
    point, undo = corrected_point(
        model, PROMPT_SETS["embedded"](), parse("left 3 cm and down 2 cm"), [], SCENE, SIZE
    )
    assert (point.u, point.v) == (610.0, 380.0)
    assert not undo


def test_a_point_outside_is_clipped_once() -> None:
    model = ScriptedModel(
        correct=[
            {"x": "target.u-100*cm", "y": "target.v"},
            {"x": "target.u", "y": "target.v-2*cm"},
        ]
    )
    point, _ = corrected_point(
        model, PROMPT_SETS["embedded"](), parse("left 100 cm and up 2 cm"), [], SCENE, SIZE
    )
    assert point.clipped
    assert (point.u, point.v) == (1.0, 340.0)


def test_a_large_model_is_asked_once() -> None:
    utterance = parse("left 3 cm and down 2 cm")
    assert PROMPT_SETS["large"]().parts(utterance) == (utterance,)
