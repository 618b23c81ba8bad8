"""Words that choose one of several things, and words that do not."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from w2c.messages import Box, PhraseEvidence
from w2c_dialogue.sight import only, twins, unknown_warnings
from w2c_dialogue.utterance import parse
from w2c_dialogue.which import ANSWERING, MIDDLE, ORDINALS, names, read_answer, read_phrase


def box(u: float, v: float, side: float = 40, score: float = 0.9) -> Box:
    half = side / 2
    return Box(left=u - half, top=v - half, right=u + half, bottom=v + half, score=score)


PAIR = (box(800, 300), box(200, 320, side=60))
ROW = (box(600, 300), box(200, 310), box(1000, 290))
STACK = (box(600, 500), box(610, 100))


def answer(text: str, boxes: tuple[Box, ...] = PAIR, phrase: str = "mug") -> int | None:
    return read_answer(parse(text).folded, phrase, boxes)


@pytest.mark.parametrize(
    ("text", "index"),
    [
        ("the left one", 1),
        ("Left!", 1),
        ("right", 0),
        ("no, I mean the one on the right side please", 0),
        ("the left hand side one", 1),
        ("the left mug", 1),
        ("the bigger one", 1),
        ("the smaller mug", 0),
        ("the nearer one", 1),
        ("the upper one", 0),
        ("second from the right", 1),
        ("the first", 1),
    ],
)
def test_an_answer_chooses(text: str, index: int) -> None:
    assert answer(text) == index


@pytest.mark.parametrize(
    "text",
    [
        "yes",
        "the mug",
        "a bit to the left",
        "move left",
        "left of the plate",
        "with your left hand",
        "that's right",
        "the third",
        "the middle one",
        "the left one and the right one",
        "first from the second",
        "lean on the left mug",
    ],
)
def test_what_chooses_nothing_is_no_answer(text: str) -> None:
    assert answer(text) is None


@given(
    words=st.lists(
        st.sampled_from([*sorted(ANSWERING), *MIDDLE, *ORDINALS, "the", "mug,", "cup"]), max_size=5
    ),
    count=st.integers(1, 7),
)
def test_any_words_choose_one_of_the_things_or_none(words: list[str], count: int) -> None:
    boxes = [box(100 + 90 * (i % 3), 100 + 50 * i, side=20 + i) for i in range(count)]
    for index in (read_answer(words, "mug", boxes), read_phrase(" ".join(words), boxes)):
        assert index is None or 0 <= index < count


def test_three_things_have_a_middle() -> None:
    assert names(ROW) == ("left", "middle", "right")
    assert [answer(f"the {name} one", ROW) for name in names(ROW)] == [1, 0, 2]


def test_things_above_each_other_are_upper_and_lower() -> None:
    assert names(STACK) == ("upper", "lower")
    assert [answer(name, STACK) for name in names(STACK)] == [1, 0]


@pytest.mark.parametrize("count", [2, 3, 4, 5])
def test_every_name_of_a_question_is_understood(count: int) -> None:
    boxes = tuple(box(100 + 150 * i, 300 + 7 * i) for i in range(count))
    assert [answer(name, boxes) for name in names(boxes)] == list(range(count))


def test_two_words_choose_together() -> None:
    corners = (box(100, 100), box(900, 100), box(100, 600), box(900, 600))
    assert answer("the lower left one", corners) == 2
    assert answer("upper right", corners) == 1


@pytest.mark.parametrize(
    ("phrase", "index"),
    [("left mug", 1), ("mug on the right", 0), ("big mug", 1), ("mug", None), ("top shelf", None)],
)
def test_a_name_may_say_which(phrase: str, index: int | None) -> None:
    assert read_phrase(phrase, PAIR) == index


def evidence(*boxes: Box, **more: object) -> PhraseEvidence:
    fields = {"found": True, "score": 0.9, "point": (800.0, 300.0), **more}
    return PhraseEvidence(phrase="red mug", boxes=list(boxes), **fields)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("second", "is_twin"),
    [
        (box(200, 300, score=0.85), True),
        (box(200, 300, score=0.7), False),
        (box(810, 300, score=0.9), False),
        (box(200, 300, side=10), False),
    ],
)
def test_a_twin_is_as_good_apart_and_no_speck(second: Box, is_twin: bool) -> None:
    assert len(twins(evidence(PAIR[0], second))) == 1 + is_twin


def test_only_one_of_two_things_is_pointed_at() -> None:
    heatmap = np.zeros((72, 128), np.uint8)
    heatmap[30, 80], heatmap[33, 21] = 255, 250
    chosen = only(evidence(*PAIR, heatmap=heatmap), PAIR[1], (1280, 720))
    assert chosen.boxes == [PAIR[1]]
    assert chosen.point == (215.0, 335.0)
    assert chosen.heatmap is not None
    assert chosen.heatmap.sum() == 250
    assert only(evidence(*PAIR), PAIR[1], (1280, 720)).point == (200.0, 320.0)
    assert only(evidence(*PAIR), PAIR[0], (1280, 720)).point == (800.0, 300.0)


def test_words_that_nobody_knows_are_told() -> None:
    assert unknown_warnings([evidence(PAIR[0])]) == ()
    (told,) = unknown_warnings([evidence(PAIR[0], unknown_words=["red"])])
    assert "'red'" in told
