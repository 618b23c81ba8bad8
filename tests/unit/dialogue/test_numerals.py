"""Numbers of several words become digits, for the model and for the grammar of its answers."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from w2c.messages import Box
from w2c_dialogue.prompts.base import SceneObject
from w2c_dialogue.prompts.bound import numbers_of
from w2c_dialogue.prompts.numerals import VALUES, in_digits, with_digits
from w2c_dialogue.prompts.sets import PROMPT_SETS
from w2c_dialogue.utterance import Mention, Span, parse

CUP = SceneObject("cup", Box(left=600.0, top=300.0, right=700.0, bottom=400.0, score=1.0))


def digits(text: str) -> str:
    return " ".join(in_digits(text.split()))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("up twenty five centimetres", "up 25 centimetres"),
        ("twenty-five, and left", "25, and left"),
        ("an inch and a half down", "1.5 inch down"),
        ("two centimetres and a half", "2.5 centimetres"),
        ("down an inch n a half, then two left", "down 1.5 inch, then two left"),
        ("two and a half cm", "2.5 cm"),
        ("left two zero millimeters", "left 20 millimeters"),
        ("one five cm", "15 cm"),
        ("a quarter of a metre upward", "0.25 metre upward"),
        ("three quarters of an inch", "0.75 inch"),
        ("a quarter inch", "0.25 inch"),
        ("one hundred and twenty px left", "120 px left"),
        ("two hundred pixels, left", "200 pixels, left"),
        ("a hundred and five px", "105 px"),
        ("1 1/2 inches", "1.5 inches"),
        ("1/2 inch up", "0.5 inch up"),
        ("1/3 inch up", "0.333 inch up"),
        ("3 and a half", "3.5"),
    ],
)
def test_what_several_words_make_together_is_one_number(text: str, expected: str) -> None:
    assert digits(text) == expected


@pytest.mark.parametrize(
    "text",
    [
        pytest.param("three cm left and two up", id="two numbers"),
        pytest.param("two three left", id="no nought and no five at the end"),
        pytest.param("twenty, five", id="a pause between"),
        pytest.param("half an inch", id="the model knows it"),
        pytest.param("a quarter of the way", id="no unit"),
        pytest.param("and a half", id="half of nothing"),
        pytest.param("+35 px in u and -20 px in v", id="signs stay"),
        pytest.param("the left-hand drawer", id="a hyphen without numbers"),
        pytest.param("1/0 of it", id="no fraction"),
        pytest.param("a foot", id="one word"),
        pytest.param("left of A and b", id="letters of objects"),
    ],
)
def test_all_else_stays(text: str) -> None:
    assert digits(text) == text


WORDS = (
    *VALUES,
    "a",
    "and",
    "half",
    "hundred",
    "quarter",
    "of",
    "inch",
    "3",
    "1/2",
    "left,",
    "five,",
)


@given(st.lists(st.sampled_from(WORDS), min_size=1, max_size=8))
def test_words_that_are_no_numbers_are_never_lost(words: list[str]) -> None:
    assert [word for word in in_digits(words) if word == "left,"] == [
        word for word in words if word == "left,"
    ]
    assert len(in_digits(words)) <= len(words)


def test_a_model_is_asked_with_digits_and_may_answer_with_them() -> None:
    prompts = PROMPT_SETS["embedded"]()
    utterance = parse("Twenty-five centimetres left of the cup")
    mentions = [Mention("cup", Span(6, 6))]

    question = prompts.relative(utterance, mentions, [CUP], 10.0)

    assert question.messages[-1].content.endswith("\n25 centimetres left of the A")
    assert "25" in numbers_of(utterance)


def test_the_parts_of_a_correction_have_digits() -> None:
    prompts = PROMPT_SETS["embedded"]()

    parts = prompts.parts(parse("an inch and a half down and two left"))

    assert [part.folded_text for part in parts] == ["1.5 inch down", "two inch left"]
    assert with_digits(parse("two left")) == parse("two left")
