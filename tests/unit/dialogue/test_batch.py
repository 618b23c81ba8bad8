"""`dialogue batch`: lines in, lines out, with the modules of the dialogue."""

from collections.abc import Mapping
from typing import Any

import msgspec
import pytest

from w2c.errors import ConnectionFailedError, DeadlineError
from w2c_dialogue.batch.answering import Answering, find_words, name_things
from w2c_dialogue.batch.commands import answer_line
from w2c_dialogue.batch.lines import Thing
from w2c_dialogue.interfaces import Choice
from w2c_dialogue.prompts.base import Question
from w2c_dialogue.prompts.embedded import EmbeddedPrompts
from w2c_dialogue.utterance import Span, parse

CUP = {"phrase": "cup", "cx": 600, "cy": 300, "w": 40, "h": 60}
JAR = {"phrase": "the jar", "cx": 900, "cy": 320, "w": 50, "h": 80}


class Model:
    """Answers by task; remembers what it was asked."""

    language_model = "scripted"

    def __init__(self, **answers: Any) -> None:
        self.answers = answers
        self.asked: list[Question] = []
        self.priors: list[Mapping[str, float]] = []

    def complete(self, question: Question) -> Any:
        self.asked.append(question)
        answer = self.answers[question.task]
        if isinstance(answer, Exception):
            raise answer
        return answer

    def choose(self, question: Question, log_prior: Mapping[str, float]) -> Choice:
        self.priors.append(log_prior)
        option = self.answers["select"]
        option = option.pop(0) if isinstance(option, list) else option
        return Choice(option, {option: 1.0})


def answer(model: Model, line: dict[str, Any]) -> dict[str, Any]:
    return answer_line(Answering(model, EmbeddedPrompts()), msgspec.json.encode(line))


def test_each_task_has_its_fields() -> None:
    model = Model(
        select="correction",
        analyze={"position": "relative", "objects": ["4-4"]},
        effector={"effector": "left_hand", "task": "reach"},
    )

    assert answer(model, {"id": 1, "task": "select", "text": "left"}) == {
        "id": 1,
        "module": "correction",
        "probabilities": {"correction": 1.0},
    }
    assert answer(model, {"id": "b", "task": "analyze", "text": "left of the Cup."}) == {
        "id": "b",
        "position": "relative",
        "objects": ["Cup"],
    }
    assert answer(model, {"id": "c", "task": "effector", "text": "grab it"}) == {
        "id": "c",
        "end_effector": "left_hand",
        "task_type": "reach",
    }


def test_a_relative_place_is_computed_from_the_given_boxes() -> None:
    model = Model(relative={"x": "(a.right+b.left)/2", "y": "a.v-2*cm"})
    line = {"id": "r", "task": "relative", "text": "between the cup and the jar"}

    found = answer(model, {**line, "objects": [JAR, CUP], "px_per_cm": 5})

    assert found == {"id": "r", "point": [747.5, 290.0], "clipped": False}
    assert model.asked[0].messages[1].content == "A left of B\nbetween the A and B"


def test_the_analyzer_finds_things_whose_words_are_not_in_the_text() -> None:
    model = Model(
        analyze={"position": "relative", "objects": ["4-4"]}, relative={"x": "a.u", "y": "a.top"}
    )
    line = {"id": "r", "task": "relative", "text": "behind of the cups", "objects": [CUP]}

    assert answer(model, line)["point"] == [600.0, 270.0]
    assert [question.task for question in model.asked] == ["analyze", "relative"]


def test_a_correction_knows_the_moves_before_it() -> None:
    model = Model(correct={"x": "start.u+last.du+moves[-2].du", "y": "target.v"})
    line = {"id": "k", "task": "correct", "text": "again", "target": [500, 300]}

    found = answer(model, {**line, "previous_moves": [[-40, 0], [10, 5]]})

    assert found["point"] == [500.0, 300.0]
    assert model.asked[0].messages[1].content == "past left, right down\nagain"


def test_an_earlier_move_that_is_not_there_is_an_error_of_the_line() -> None:
    model = Model(correct={"x": "target.u+last.du", "y": "target.v"})
    line = {"id": "k", "task": "correct", "text": "again", "target": [500, 300]}

    assert "earlier move" in answer(model, line)["error"]


def test_without_a_target_the_first_turn_is_an_instruction() -> None:
    model = Model(select=["prediction", "correction", "confirmation", "prediction"])
    turns = ["on the cup", "left", "ok", "the jar"]

    found = answer(model, {"id": "d", "task": "dialogue", "turns": turns})

    assert found["modules"] == ["prediction", "correction", "confirmation", "prediction"]
    assert [bool(prior) for prior in model.priors] == [True, False, False, False]


@pytest.mark.parametrize(
    ("line", "reason", "number"),
    [
        (b"{broken", "malformed", None),
        (b"[]", "object", None),
        (b'{"id": 7, "task": "dance", "text": "x"}', "dance", 7),
        (b'{"id": 8, "task": "select"}', "text", 8),
        (b'{"id": 9, "task": "select", "text": ""}', "no words", 9),
        (b'{"id": 10, "task": "correct", "text": "left", "target": [1e999, 2]}', "range", 10),
        (
            b'{"id": 11, "task": "relative", "text": "left of it", "objects": [{"phrase": "it", '
            b'"cx": 1, "cy": 1, "w": -2, "h": 2}]}',
            "objects",
            11,
        ),
    ],
)
def test_a_bad_line_is_answered_with_the_reason(
    line: bytes, reason: str, number: int | None
) -> None:
    found = answer_line(Answering(Model(select="correction"), EmbeddedPrompts()), line)

    assert found["id"] == number
    assert reason in found["error"]


def test_a_slow_model_fails_a_line_and_a_lost_one_the_batch() -> None:
    line = {"id": "e", "task": "effector", "text": "grab it"}

    assert "too late" in answer(Model(effector=DeadlineError("too late")), line)["error"]
    with pytest.raises(ConnectionFailedError):
        answer(Model(effector=ConnectionFailedError("gone")), line)


def test_words_of_a_thing_are_found_once_each() -> None:
    utterance = parse("from the mug to the other mug's handle")

    assert find_words(utterance, "Mug", []) == Span(3, 3)
    assert find_words(utterance, "mug", [Span(3, 3)]) == Span(7, 7)
    assert find_words(utterance, "other mug", []) == Span(6, 7)
    assert find_words(utterance, "jar", []) is None
    assert name_things(utterance, [Thing(phrase="jar", cx=0, cy=0, w=1, h=1)]) is None
