"""Answers that speak of nothing but the utterance and its scene: grammars compile, answers fit."""

import json
from typing import Any

import llguidance
import numpy as np
import pytest

from w2c.messages import Box
from w2c_dialogue.corpus import generate
from w2c_dialogue.expressions import correction_symbols, evaluate
from w2c_dialogue.prompts.base import CorrectionScene, Move, PromptSet, Question, SceneObject
from w2c_dialogue.prompts.bound import MOST_NUMBERS, numbers_of
from w2c_dialogue.prompts.embedded import NAMED_MOVES, EmbeddedPrompts
from w2c_dialogue.prompts.large import LargePrompts
from w2c_dialogue.prompts.sets import make_prompts
from w2c_dialogue.utterance import Mention, Span, parse
from w2c_llm.gbnf import grammar_of
from w2c_llm.schema import check_schema
from w2c_llm.values import violation

CUP = SceneObject("cup", Box(left=600, top=300, right=700, bottom=380, score=1.0))
LONGEST = CorrectionScene((640, 360), (600, 360), (Move(4, 2),) * 50, ("x",) * 50, (CUP,) * 3, 9.0)
FRESH = CorrectionScene((640, 360), (640, 360), (), (), (), 9.0)


def point_schema(scene: CorrectionScene, text: str) -> dict[str, Any]:
    mentions = [Mention("cup", None)] * len(scene.objects)
    schema = EmbeddedPrompts().correct(parse(text), mentions, scene).schema
    assert schema is not None
    return check_schema(schema)


def fits(schema: dict[str, Any], x: str) -> bool:
    return violation({"x": x, "y": "target.v"}, schema) is None


@pytest.mark.parametrize("prompts", [EmbeddedPrompts(), LargePrompts(bound=True)])
@pytest.mark.parametrize("text", ["left", 'a "C++" (mug\'s) 3,5 cm ' + "word " * 55])
def test_both_grammars_take_every_bound_schema(prompts: PromptSet, text: str) -> None:
    utterance = parse(text)
    questions = [
        prompts.analyze(utterance),
        prompts.objects(utterance),
        prompts.relative(utterance, [Mention("cup", None)] * 3, [CUP] * 3, 9.0),
        prompts.correct(utterance, [Mention("cup", None)] * 3, LONGEST),
    ]
    for question in questions:
        assert question.schema is not None
        checked = check_schema(question.schema)
        assert grammar_of(checked)
        compiled = llguidance.LLMatcher.grammar_from_json_schema(json.dumps(checked))
        assert llguidance.LLMatcher.validate_grammar(compiled) == ""


def test_an_expression_has_only_what_the_scene_has() -> None:
    fresh = point_schema(FRESH, "137 px to the left")
    assert fits(fresh, "target.u-137")
    assert fits(fresh, "target.u-20")
    assert not fits(fresh, "target.u-173"), "nobody said so"
    assert not fits(fresh, "target.u+last.du"), "there was no move"
    assert not fits(fresh, "a.left"), "no object was named"
    longest = point_schema(LONGEST, "back")
    assert fits(longest, f"target.u-moves[-{NAMED_MOVES}].du+c.width")
    assert not fits(longest, f"moves[-{NAMED_MOVES + 1}].du")
    assert fits(longest, "target.u-2.54*12*cm*last.way.u")
    assert fits(longest, "target.v+0.1*12*cm*c.way.v")


def test_a_bound_expression_is_one_that_the_parser_takes() -> None:
    x = "target.u-0.5*(b.left - moves[-2].size)/2"
    assert fits(point_schema(LONGEST, "x"), x)
    assert evaluate(x, correction_symbols(LONGEST)) > 0


def test_numbers_are_those_that_were_said() -> None:
    said = numbers_of("3 cm left, then 2,5 up and .7 of 1e999 or 12345678")
    assert {"3", "2.5", "0.7", "999", "20", "0.5"} <= set(said)
    assert len(said) == len(set(said))
    assert len(numbers_of(" ".join(str(n) for n in range(200, 250)))) == MOST_NUMBERS


def test_a_phrase_of_a_bound_large_model_is_words_of_the_operator() -> None:
    utterance = parse("Lean on the Red Book, please")
    schema = LargePrompts(bound=True).objects(utterance).schema
    assert schema is not None
    phrase = check_schema(schema)["properties"]["objects"]["items"]
    assert violation("the Red Book", phrase) is None
    assert violation("crimson tome", phrase) is not None
    assert LargePrompts().read_mention("the Red Book", utterance).span == Span(4, 5)


def test_the_form_of_answers_can_be_switched() -> None:
    def bound(prompts: PromptSet) -> bool:
        schema = prompts.correct(parse("x"), [], FRESH).schema
        return "x-arithmetic-of" in json.dumps(schema)

    assert bound(make_prompts("embedded"))
    assert not bound(make_prompts("large"))
    assert not bound(make_prompts("embedded", "free"))
    assert bound(make_prompts("large", "bound"))


class Listening(EmbeddedPrompts):
    """Keeps what is asked for arithmetic."""

    def __init__(self) -> None:
        super().__init__()
        self.asked: dict[str, Question] = {}

    def relative(self, *arguments: Any) -> Question:
        return self._keep(super().relative(*arguments))

    def correct(self, *arguments: Any) -> Question:
        return self._keep(super().correct(*arguments))

    def _keep(self, question: Question) -> Question:
        self.asked[question.messages[-1].content] = question
        return question


def test_every_answer_of_the_corpus_can_be_given(monkeypatch: pytest.MonkeyPatch) -> None:
    """What the model is trained to write must not be forbidden when it is asked."""
    prompts = Listening()
    monkeypatch.setattr(generate, "PROMPTS", prompts)
    lines = list(generate.examples(np.random.default_rng(3), 160, held_out=False))
    arithmetic = [line for line in lines if line.task in ("relative", "correct")]
    assert len(arithmetic) > 30
    for line in arithmetic:
        question = prompts.asked[line.messages[-1]["content"]]
        assert question.schema is not None
        reason = violation(json.loads(line.answer), check_schema(question.schema))
        assert reason is None, (line.messages[-1]["content"], reason)
