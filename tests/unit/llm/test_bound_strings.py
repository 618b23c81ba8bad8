"""Words of a text and arithmetic of a scene: what may be said, and nothing else."""

import re
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fakes.language_model import ScriptedBackend
from w2c.clock import RealClock
from w2c.errors import ModelError, RefusedError
from w2c.messages import ChatMessage, CompleteRequest
from w2c_llm.answering import complete
from w2c_llm.backend import Budget
from w2c_llm.gbnf import grammar_of
from w2c_llm.llama_cpp_backend import LlamaCppBackend
from w2c_llm.openai_backend import described
from w2c_llm.schema import MAX_PATTERN, check_schema
from w2c_llm.values import violation

TEXT = 'put it left of the "red mug", (or) my C++ book!'
SCENE = {"symbols": ["a.left", "a.width", "moves[-2].du"], "numbers": ["0.5", "2"]}


def words_of(text: str, **more: Any) -> dict[str, Any]:
    return {"type": "string", "x-words-of": text, **more}


def arithmetic(scene: object) -> dict[str, Any]:
    return {"type": "string", "x-arithmetic-of": scene}


def fits(schema: dict[str, Any], value: str) -> bool:
    return violation(value, check_schema(schema)) is None


@pytest.mark.parametrize(
    ("phrase", "allowed"),
    [
        ("red mug", True),
        ("mug", True),
        ('the "red mug", (or) my C++', True),
        ("the red mug", False),
        ("C++ book", True),
        ("C", False),
        ("or", True),
        ('left of the "red mug', True),
        ("my C++ book", True),
        ("red  mug", False),
        ("mug red", False),
        ("blue mug", False),
        ("", False),
        ("Red mug", False),
    ],
)
def test_a_phrase_is_a_run_of_the_words(phrase: str, allowed: bool) -> None:
    assert fits(words_of(TEXT), phrase) == allowed


def test_a_phrase_has_no_more_words_than_allowed() -> None:
    assert fits(words_of(TEXT, **{"x-longest": 2}), "put it")
    assert not fits(words_of(TEXT, **{"x-longest": 2}), "put it left")


@pytest.mark.parametrize(
    ("expression", "allowed"),
    [
        ("a.left", True),
        ("-a.left - 0.5 * a.width", True),
        ("2*(a.left+a.width)/2", True),
        ("moves[-2].du+2", True),
        ("a.left+3", False),
        ("a.right", False),
        ("moves[-1].du", False),
        ("axleft", False),
        ("((2))", False),
        ("2+2+2+2+2+2", False),
        ("2+", False),
        ("", False),
    ],
)
def test_arithmetic_has_only_what_the_scene_has(expression: str, allowed: bool) -> None:
    assert fits(arithmetic(SCENE), expression) == allowed


def test_without_a_list_any_short_number_may_stand() -> None:
    free = arithmetic({"symbols": ["cm"]})
    assert fits(free, "12.5*cm")
    assert not fits(free, "1e999")
    assert not fits(free, "99999")


@settings(max_examples=20)
@given(seed=st.integers(0, 2**31), text=st.lists(st.text("ab.'é+", min_size=1), min_size=1))
def test_a_model_of_random_weights_says_nothing_else(
    shared_backend: LlamaCppBackend, seed: int, text: list[str]
) -> None:
    said = " ".join([*text, "mug"])
    schema = {
        "type": "object",
        "properties": {"object": words_of(said, **{"x-longest": 3}), "x": arithmetic(SCENE)},
        "required": ["object", "x"],
    }
    request = CompleteRequest(
        messages=[ChatMessage(role="user", content=said)],
        schema=schema,
        seed=seed,
        temperature=1.0,
    )
    value = complete(shared_backend, request, Budget(RealClock(), 60.0)).value
    assert value["object"] in " ".join(word for word in said.split() if word.strip(".'"))
    known = "|".join(map(re.escape, [*SCENE["symbols"], *SCENE["numbers"]]))
    assert re.sub(known, "", value["x"]).strip("-+*/() ") == ""


def test_a_backend_without_a_grammar_is_held_to_it_too() -> None:
    request = CompleteRequest(
        messages=[ChatMessage(role="user", content="x")], schema=words_of("the red mug")
    )
    backend = ScriptedBackend(['"blue mug"', '"red mug"'])
    assert complete(backend, request, Budget(RealClock(), 9.0)).value == "red mug"
    with pytest.raises(ModelError, match="must match"):
        complete(ScriptedBackend(['"a"', '"b"']), request, Budget(RealClock(), 9.0))


def test_long_texts_have_grammars_and_servers_are_told_in_words() -> None:
    schema = check_schema(words_of(" ".join(f"word{index}" for index in range(60))))
    assert len(schema["pattern"]) > MAX_PATTERN
    assert grammar_of(schema)
    assert set(described({"items": [schema]})["items"][0]) == {"type", "description"}
    short = check_schema(words_of("the mug"))
    assert described(short) == short


@pytest.mark.parametrize(
    ("schema", "reason"),
    [
        (words_of(""), "0 words"),
        (words_of("... !"), "0 words"),
        (words_of("a " * 101), "101 words"),
        (words_of("a\x07b"), "control"),
        (words_of("a", **{"x-longest": 0}), "x-longest"),
        ({"type": "string", "x-words-of": 3}, "must be a text"),
        ({"type": "string", "x-longest": 3}, "maxLength"),
        (arithmetic([]), "must be an object"),
        (arithmetic({"symbol": []}), "must be an object"),
        (arithmetic({"symbols": [""]}), "no text"),
        (arithmetic({"symbols": [3]}), "no text"),
        (arithmetic({"numbers": []}), "neither"),
        (arithmetic({"numbers": ["1e999"]}), "none"),
        (arithmetic({"numbers": ["-2"]}), "sign"),
        (arithmetic({"symbols": ["a"] * 65}), "at most 64"),
    ],
)
def test_what_makes_no_sense_is_refused(schema: dict[str, Any], reason: str) -> None:
    with pytest.raises(RefusedError, match=reason):
        check_schema(schema)
