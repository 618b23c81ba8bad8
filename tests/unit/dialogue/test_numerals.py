"""Numbers of several words become digits, for the model and for the grammar of its answers."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fakes.dialogue_world import ScriptedModel
from w2c.errors import RefusedError
from w2c.messages import Box
from w2c_dialogue.corpus import measures
from w2c_dialogue.corrector import corrected_point
from w2c_dialogue.prompts.base import CorrectionScene, SceneObject
from w2c_dialogue.prompts.bound import numbers_of
from w2c_dialogue.prompts.numerals import UNITS, VALUES, check_numbers, in_digits, with_digits
from w2c_dialogue.prompts.sets import PROMPT_SETS
from w2c_dialogue.relative import described
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
        ("two centimetres and a half, then up", "2.5 centimetres, then up"),
        ("down an inch n a half, then two left", "down 1.5 inch, then two left"),
        ("two and a half cm", "2.5 cm"),
        ("3 and a half", "3.5"),
        ("left two zero millimeters", "left 20 millimeters"),
        ("one zero cm", "10 cm"),
        ("three five zero px", "350 px"),
        ("a quarter of a metre upward", "0.25 metre upward"),
        ("three quarters of an inch", "0.75 inch"),
        ("three-quarters of an inch", "0.75 inch"),
        ("a quarter inch", "0.25 inch"),
        ("one hundred and twenty px left", "120 px left"),
        ("two hundred pixels, left", "200 pixels, left"),
        ("a hundred five px", "105 px"),
        ("left a hundred and ten down", "left 100 and ten down"),
        ("1 1/2 inches", "1.5 inches"),
        ("-1 1/2 inches", "-1.5 inches"),
        ("+2 and a half cm in u", "+2.5 cm in u"),
        ("1/2 inch up", "0.5 inch up"),
        ("1/3 of the way", "0.33 of the way"),
    ],
)
def test_what_several_words_make_together_is_one_number(text: str, expected: str) -> None:
    assert digits(text) == expected
    assert digits(expected) == expected


@pytest.mark.parametrize(
    "text",
    [
        pytest.param("three cm left and two up", id="two numbers"),
        pytest.param("two three cm", id="two or three"),
        pytest.param("four five cm", id="four or five"),
        pytest.param("two zero", id="no unit"),
        pytest.param("the red one five cm left", id="one is a thing"),
        pytest.param("one two five zero px", id="too many digits"),
        pytest.param("twenty, five", id="a pause between"),
        pytest.param("left two, and a half cm up", id="a pause before a half"),
        pytest.param("left two cm and a half cm up", id="half of another unit"),
        pytest.param("half an inch", id="the model knows it"),
        pytest.param("a quarter of the way", id="no unit of a quarter"),
        pytest.param("and a half", id="half of nothing"),
        pytest.param("+35 px in u and -20 px in v", id="signs stay"),
        pytest.param("2,5 cm", id="a decimal comma stays"),
        pytest.param("the left-hand, and/or the off-white, drawer", id="other hyphens"),
        pytest.param("1/0 of it", id="no fraction"),
        pytest.param("left of A and a foot off", id="letters of things"),
    ],
)
def test_all_else_stays(text: str) -> None:
    assert digits(text) == text


NUMBERS = (*VALUES, "a", "and", "half", "hundred", "quarter", "of", "inch", "3", "1/2", "five,")
OTHERS = ("left,", "left-hand,", "up", "A", "off-white", "or")


@given(st.lists(st.sampled_from((*NUMBERS, *OTHERS)), min_size=1, max_size=9))
def test_no_other_word_is_lost_and_digits_stay_digits(words: list[str]) -> None:
    made = in_digits(words)

    assert [word for word in made if word in OTHERS] == [word for word in words if word in OTHERS]
    assert not [word for word in made if word.endswith(",,")]
    assert in_digits(made) == made


def test_every_unit_that_the_corpus_says_is_a_unit() -> None:
    assert {name for _, (listed, _) in measures.UNITS for name in listed} <= UNITS
    assert set(measures.PIXELS[0]) <= UNITS


def test_a_model_is_asked_with_digits_and_may_answer_with_them() -> None:
    prompts = PROMPT_SETS["embedded"]()
    utterance = parse("Twenty-five centimetres left of the cup")
    mentions = [Mention("cup", Span(6, 6))]

    question = prompts.relative(utterance, mentions, [CUP], 10.0)

    assert question.messages[-1].content.endswith("\n25 centimetres left of the A")
    assert "25" in numbers_of(question.messages[-1].content)


def test_the_parts_of_a_correction_have_digits() -> None:
    prompts = PROMPT_SETS["embedded"]()

    parts = prompts.parts(parse("an inch and a half down and two left"))

    assert [part.folded_text for part in parts] == ["1.5 inch down", "two inch left"]
    assert with_digits(parse("two left")) == parse("two left")


@pytest.mark.parametrize("number", ["1e999", "-2e3", "1.5e-7,"])
def test_a_number_with_a_power_of_ten_is_refused_by_name(number: str) -> None:
    with pytest.raises(RefusedError, match=re.escape(f"'{number.rstrip(',')}'")):
        check_numbers(parse(f"move it {number} cm left"))


@pytest.mark.parametrize(
    "text", ["1280 px left", "-20 in v", "the a4 sheet", "3.5 cm", "2x as far", "999999 px left"]
)
def test_other_numbers_are_not(text: str) -> None:
    check_numbers(parse(text))


def test_neither_a_correction_nor_a_place_follows_such_a_number() -> None:
    model, prompts = ScriptedModel(), PROMPT_SETS["embedded"]()
    scene = CorrectionScene((640.0, 360.0), (640.0, 360.0), (), (), (), 10.0)
    with pytest.raises(RefusedError):
        corrected_point(model, prompts, parse("1e999 cm left"), [], scene, (1280, 720))
    with pytest.raises(RefusedError):
        described(
            model,
            prompts,
            utterance=parse("1e9 cm left of the cup"),
            mentions=[Mention("cup", Span(6, 6))],
            objects=[CUP],
            pixels_per_cm=10.0,
        )
