"""What an ablation takes out of the questions, and that nothing else changes."""

import json
import re

import jsonschema
import pytest

from w2c.errors import ConfigError
from w2c.messages import Box
from w2c_dialogue.expressions import evaluate_point, object_symbols
from w2c_dialogue.prompts.ablations import AblationName, ablated
from w2c_dialogue.prompts.base import CorrectionScene, Move, PromptSet, Question, SceneObject
from w2c_dialogue.prompts.embedded import EmbeddedPrompts
from w2c_dialogue.prompts.large import LargePrompts
from w2c_dialogue.prompts.single import EXAMPLES
from w2c_dialogue.utterance import parse
from w2c_llm.schema import check_schema

CUP = SceneObject("cup", Box(left=600, top=300, right=700, bottom=380, score=1.0))
SCENE = CorrectionScene((640, 360), (600, 360), (Move(40, 0),), ("right",), (CUP,), 10.0)
SAID = parse("left of the cup")


def questions(prompts: PromptSet) -> dict[str, Question]:
    asked = (
        prompts.select(SAID),
        prompts.analyze(SAID),
        prompts.objects(SAID),
        prompts.relative(SAID, (), (CUP,), 10.0),
        prompts.correct(SAID, (), SCENE),
        prompts.effector(SAID),
    )
    return {question.task: question for question in asked}


def system(question: Question) -> str:
    return question.messages[0].content


@pytest.mark.parametrize("name", ["direct_number", "no_reasoning", "zero_shot"])
def test_the_question_itself_and_its_fields_stay(name: AblationName) -> None:
    before, after = questions(LargePrompts()), questions(ablated(LargePrompts(), name))

    for task, question in after.items():
        assert question.messages[-1].content == before[task].messages[-1].content
        assert question.options == before[task].options
        assert question.constant_messages == len(question.messages) - 1
        if question.schema is not None:
            check_schema(question.schema)
            asked = before[task].schema
            assert asked is not None
            assert set(asked["properties"]) - set(question.schema["properties"]) <= {
                "chain_of_thought"
            }


def test_without_reasoning_nobody_is_told_to_think() -> None:
    for task, question in questions(ablated(LargePrompts(), "no_reasoning")).items():
        assert "Think" not in system(question), task
        assert all("chain_of_thought" not in message.content for message in question.messages)
        if question.schema is not None:
            assert "chain_of_thought" not in question.schema["properties"]
        assert len(question.messages) > 5  # the examples stay


def test_zero_shot_leaves_the_explanation_and_the_question() -> None:
    for question in questions(ablated(LargePrompts(), "zero_shot")).values():
        assert [message.role for message in question.messages] == ["system", "user"]
        assert question.constant_messages == 1


def test_a_direct_number_is_computed_in_the_examples_too() -> None:
    after = questions(ablated(LargePrompts(), "direct_number"))
    for task in ("relative", "correct"):
        question = after[task]
        assert "arithmetic" not in system(question)
        assert "x and y as numbers." in system(question)
        examples = [m.content for m in question.messages if m.role == "assistant"]
        assert len(examples) == 5
        for example in examples:
            assert re.fullmatch(r"-?\d+", json.loads(example)["x"])
        assert question.schema is not None
        assert re.fullmatch(question.schema["properties"]["y"]["pattern"], "360")
        assert not re.fullmatch(question.schema["properties"]["y"]["pattern"], "300+60")
    analyze = questions(LargePrompts())["analyze"]
    assert after["analyze"].schema == analyze.schema
    assert system(after["analyze"]) == system(analyze)


def test_nothing_is_taken_by_none_and_the_embedded_set_has_nothing_to_take() -> None:
    prompts = LargePrompts()

    assert ablated(prompts, "none") is prompts
    with pytest.raises(ConfigError, match="--prompts large"):
        ablated(EmbeddedPrompts(), "single_prompt")
    assert ablated(prompts, "zero_shot").name == "large, zero_shot"


def test_one_prompt_for_everything_has_examples_that_hold() -> None:
    question = ablated(LargePrompts(), "single_prompt").analyze(SAID)
    assert question.schema is not None
    check_schema(question.schema)
    symbols = object_symbols([CUP.box, CUP.box], 10.0)

    assert len([m for m in question.messages if m.role == "assistant"]) == len(EXAMPLES) == 5
    for message in question.messages:
        if message.role == "assistant":
            answer = json.loads(message.content)
            jsonschema.validate(answer, question.schema)
            assert not evaluate_point(answer["x"], answer["y"], symbols, (1280, 720)).clipped
