"""Both prompt sets ask well-formed questions; their examples are right by the rules they state."""

import json

import jsonschema
import pytest

from w2c.errors import ModelError
from w2c.messages import Box
from w2c_dialogue.expressions import evaluate_point
from w2c_dialogue.prompts import large_texts
from w2c_dialogue.prompts.base import CorrectionScene, Move, PromptSet, Question, SceneObject
from w2c_dialogue.prompts.embedded import EmbeddedPrompts, describe_boxes, describe_moves
from w2c_dialogue.prompts.large import LargePrompts
from w2c_dialogue.prompts.sets import PROMPT_SETS, PromptSetName
from w2c_dialogue.prompts.spans import MAX_ENUM
from w2c_dialogue.utterance import Mention, Span, Utterance, parse
from w2c_llm.schema import check_schema

CUP = SceneObject("cup", Box(left=600, top=300, right=700, bottom=380, score=1.0))
BOOK = SceneObject("book", Box(left=200, top=310, right=400, bottom=420, score=1.0))
SCENE = CorrectionScene((640, 360), (600, 360), (Move(40, 0),), ("move right",), (CUP,), 12.0)


def questions(prompts: PromptSet, utterance: Utterance) -> list[Question]:
    mentions = [Mention("cup", None)]
    return [
        prompts.analyze(utterance),
        prompts.objects(utterance),
        prompts.relative(utterance, mentions, [CUP], 12.0),
        prompts.correct(utterance, mentions, SCENE),
        prompts.effector(utterance),
    ]


@pytest.mark.parametrize("name", sorted(PROMPT_SETS))
@pytest.mark.parametrize("count", [1, 9, 10, 19, 20, 37, 60])
def test_the_language_service_takes_every_schema(name: PromptSetName, count: int) -> None:
    prompts = PROMPT_SETS[name]()
    for question in questions(prompts, parse("word " * count)):
        assert question.schema is not None
        check_schema(question.schema)
        assert 0 < question.constant_messages < len(question.messages)


@pytest.mark.parametrize("name", sorted(PROMPT_SETS))
def test_leading_messages_are_the_same_for_every_utterance(name: PromptSetName) -> None:
    prompts = PROMPT_SETS[name]()
    one, other = parse("lean on the cup"), parse("a bit left")
    pairs = zip(
        [*questions(prompts, one), prompts.select(one)],
        [*questions(prompts, other), prompts.select(other)],
        strict=True,
    )
    for a, b in pairs:
        constant = a.constant_messages
        assert [m.content for m in a.messages[:constant]] == [
            m.content for m in b.messages[:constant]
        ]


@pytest.mark.parametrize("count", [3, 24, 45, 60])
def test_spans_of_the_embedded_schema_are_those_of_the_utterance(count: int) -> None:
    schema = EmbeddedPrompts().objects(parse("word " * count)).schema
    assert schema is not None
    items = schema["properties"]["objects"]["items"]
    assert len(items.get("enum", [])) <= MAX_ENUM
    for text, allowed in (
        ("1-1", True),
        (f"{count}-{count}", True),
        (f"{count + 1}-{count + 1}", False),
        ("0-1", False),
        ("1", False),
    ):
        valid = jsonschema.Draft202012Validator(items).is_valid(text)
        assert valid == allowed, text


def test_facts_about_boxes() -> None:
    assert describe_boxes([CUP.box]) == "A middle"
    assert describe_boxes([BOOK.box]) == "A left"
    assert describe_boxes([CUP.box, BOOK.box]) == "A right of B"
    assert describe_boxes([BOOK.box, CUP.box]) == "A left of B"
    assert describe_boxes([]) == "nothing"


def test_facts_about_moves() -> None:
    assert describe_moves([]) == "past none"
    moves = [Move(9, 9), Move(-40, 0), Move(30, -20), Move(1, 40)]
    assert describe_moves(moves) == "past left, right up, down"


@pytest.mark.parametrize("value", ["", "5", "5-", "-5", "a-b", "1-2-3", "1 - 2", "²-³", "9-9"])
def test_what_is_no_span_is_refused(value: str) -> None:
    with pytest.raises(ModelError):
        EmbeddedPrompts().read_mention(value, parse("on the red book"))


def test_phrases_of_large_models_are_found_in_the_utterance() -> None:
    prompts, utterance = LargePrompts(), parse("Lean on the Red Book, please")
    assert prompts.read_mention("the red book", utterance) == Mention("Red Book", Span(4, 5))
    assert prompts.read_mention("crimson tome", utterance) == Mention("crimson tome", None)
    with pytest.raises(ModelError):
        prompts.read_mention("...", utterance)


@pytest.mark.parametrize("task", ["ANALYZE", "OBJECTS", "RELATIVE", "CORRECT", "EFFECTOR"])
def test_there_are_five_examples_and_each_fits_the_schema(task: str) -> None:
    examples: large_texts.Examples = getattr(large_texts, f"{task}_EXAMPLES")
    by_task = {
        q.task.upper().replace("ANALYZE", "ANALYZE"): q
        for q in questions(LargePrompts(), parse("x"))
    }
    schema = by_task[task].schema
    assert schema is not None
    assert len(examples) == 5
    for _, answer in examples:
        jsonschema.validate(answer, schema)
        assert list(answer) == list(schema["properties"])


@pytest.mark.parametrize(
    ("examples", "points"),
    [
        (
            large_texts.RELATIVE_EXAMPLES,
            [(344, 300), (700, 430), (375, 410), (900, 465), (955, 560)],
        ),
        (
            large_texts.CORRECT_EXAMPLES,
            [(480, 300), (620, 300), (680, 340), (710, 393), (300, 300)],
        ),
    ],
)
def test_arithmetic_of_the_examples(
    examples: large_texts.Examples, points: list[tuple[float, float]]
) -> None:
    for (_, answer), expected in zip(examples, points, strict=True):
        point = evaluate_point(answer["x"], answer["y"], {}, (1280, 720))
        assert (point.u, point.v) == pytest.approx(expected)


def test_large_questions_hold_boxes_history_and_target_as_in_the_paper() -> None:
    content = LargePrompts().correct(parse("twice as much"), [], SCENE).messages[-1].content
    assert "'move right' moved it by [40, 0]" in content
    assert "Cup is at [650, 340] with width=100 and height=80." in content
    assert "Target is at [640, 360]." in content
    assert content.endswith("twice as much")
    example = LargePrompts().analyze(parse("x")).messages[2]
    assert "chain_of_thought" in json.loads(example.content)


@pytest.mark.parametrize(
    ("pixels_per_cm", "told"),
    [(10.0, "10"), (2.5, "2.5"), (0.3, "0.3"), (8.74, "8.7"), (31.4, "31")],
)
def test_a_large_model_is_told_the_scale_as_exactly_as_it_matters(
    pixels_per_cm: float, told: str
) -> None:
    """2 instead of 2.5 pixels would make 10 cm 20 % too short."""
    question = LargePrompts().relative(parse("5 cm left of it"), [], [], pixels_per_cm)
    assert question.messages[-1].content.startswith(f"1 cm is {told} pixels.")
