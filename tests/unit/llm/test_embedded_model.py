"""The model that is shipped answers the sentences of the demo, through the service's own path."""

from collections.abc import Iterator
from typing import Any

import pytest

from w2c.clock import RealClock
from w2c.messages import ChatMessage, ChooseRequest, CompleteRequest
from w2c_llm.answering import choose, complete
from w2c_llm.backend import Budget
from w2c_llm.config import EMBEDDED_MODEL
from w2c_llm.llama_cpp_backend import LlamaCppBackend

SPAN = {"type": "string", "pattern": "^[1-9][0-9]?-[1-9][0-9]?$"}
EXPRESSION = {"type": "string", "pattern": r"^[a-z0-9.+*/()\[\]-]{1,60}$"}


def closed(**properties: Any) -> dict[str, Any]:
    return {"type": "object", "properties": properties, "required": list(properties)}


OBJECTS = {"type": "array", "items": SPAN, "maxItems": 3}
POINT = closed(x=EXPRESSION, y=EXPRESSION)
SCHEMAS = {
    "analyze": closed(position={"enum": ["absolute", "relative"]}, objects=OBJECTS),
    "objects": closed(objects=OBJECTS),
    "relative": POINT,
    "correct": POINT,
    "effector": closed(
        effector={"enum": ["left_hand", "right_hand", "left_foot", "right_foot", "unspecified"]},
        task={"enum": ["contact", "reach"]},
    ),
}


@pytest.fixture(scope="module")
def embedded() -> Iterator[LlamaCppBackend]:
    backend = LlamaCppBackend(EMBEDDED_MODEL, context=1024, threads=1)
    yield backend
    backend.close()


def chat(task: str, text: str) -> list[ChatMessage]:
    return [ChatMessage(role="system", content=task), ChatMessage(role="user", content=text)]


@pytest.mark.parametrize(
    ("words", "module"),
    [
        ("place your right hand on top of the book", "prediction"),
        ("with your left hand, reach for the cup", "prediction"),
        ("move a bit to the left", "correction"),
        ("twice as much", "correction"),
        ("closer to the mug", "correction"),
        ("that's perfect", "confirmation"),
        ("yes", "confirmation"),
    ],
)
def test_it_knows_which_module_a_sentence_is_for(
    embedded: LlamaCppBackend, words: str, module: str
) -> None:
    request = ChooseRequest(
        messages=chat("select", words),
        options=["prediction", "correction", "confirmation"],
        constant_messages=1,
    )
    choice = choose(embedded, request, Budget(RealClock(), 60.0))
    assert choice.option == module
    assert choice.probabilities[module] > 0.8


@pytest.mark.parametrize(
    ("task", "words", "answer"),
    [
        (
            "effector",
            "place your right hand on top of the book",
            {"effector": "right_hand", "task": "contact"},
        ),
        (
            "effector",
            "with your left hand, reach for the cup",
            {"effector": "left_hand", "task": "reach"},
        ),
        (
            "analyze",
            "place1 your2 right3 hand4 on5 top6 of7 the8 book9",
            {"position": "absolute", "objects": ["9-9"]},
        ),
        (
            "analyze",
            "with1 your2 left3 hand,4 reach5 for6 the7 cup8",
            {"position": "absolute", "objects": ["8-8"]},
        ),
        (
            "analyze",
            "put1 your2 left3 hand4 next5 to6 the7 box8",
            {"position": "relative", "objects": ["8-8"]},
        ),
        ("objects", "move1 a2 bit3 to4 the5 left6", {"objects": []}),
        ("objects", "closer1 to2 the3 mug4", {"objects": ["4-4"]}),
        (
            "relative",
            "A left\nput your left hand to the right of the A",
            {"x": "a.right+0.2*a.width", "y": "a.v"},
        ),
        (
            "correct",
            "past none\nmove a bit to the left",
            {"x": "target.u-20", "y": "target.v"},
        ),
        ("correct", "past none\n5 cm to the right", {"x": "target.u+5*cm", "y": "target.v"}),
    ],
)
def test_it_answers_each_task(
    embedded: LlamaCppBackend, task: str, words: str, answer: dict[str, Any]
) -> None:
    request = CompleteRequest(messages=chat(task, words), schema=SCHEMAS[task], constant_messages=1)
    assert complete(embedded, request, Budget(RealClock(), 60.0)).value == answer


def test_it_is_small_enough_to_be_in_the_repository() -> None:
    assert EMBEDDED_MODEL.stat().st_size <= 12_000_000
    assert (EMBEDDED_MODEL.parent / "README.md").is_file(), "its card"
