"""Grammars of llama.cpp: made from schemas, tried before use, and no wider than the schema."""

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from support.compact import is_compact
from support.words import words_without_marks
from w2c.clock import RealClock
from w2c.errors import RefusedError
from w2c.messages import ChatMessage, CompleteRequest
from w2c_llm.answering import complete
from w2c_llm.backend import Budget
from w2c_llm.gbnf import check_grammar, grammar_of
from w2c_llm.gbnf_pattern import pattern_rule
from w2c_llm.llama_cpp_backend import LlamaCppBackend
from w2c_llm.schema import check_schema


def obj(**properties: Any) -> dict[str, Any]:
    return {"type": "object", "properties": properties, "required": list(properties)}


SPAN = {"type": "string", "pattern": "^[1-9][0-9]?-[1-9][0-9]?$"}
SCHEMAS: list[dict[str, Any]] = [
    {"enum": ["left", 'with "quotes"', "back\\slash", "café", 3, None]},
    obj(list={"type": "array", "items": {"type": "array", "items": SPAN, "maxItems": 2}}),
    {**obj(a={"enum": [1]}, b={"type": "null"}, c={"type": "boolean"}), "required": ["b"]},
    {**obj(a={"type": "null"}, b={"type": "null"}), "required": []},
    obj(note={"type": "string", "maxLength": 9, "pattern": r"^[ -~]*$"}),
    obj(x={"type": "string", "pattern": r"^(a|b\.(u|v))([-+*/]\d{1,3}(\.\d)?){0,2}$"}),
    obj(n={"type": "integer", "minimum": 0}, x={"type": "number"}),
    {"anyOf": [obj(kind={"const": "stop"}), obj(kind={"const": "go"}, n={"type": "integer"})]},
]
SCHEMAS[1]["properties"]["list"]["maxItems"] = 2


@pytest.fixture(scope="module")
def backend(tiny_model: Path) -> Iterator[LlamaCppBackend]:
    backend = LlamaCppBackend(tiny_model, context=1024, threads=1, constraint="gbnf")
    yield backend
    backend.close()


@settings(max_examples=30)
@given(st.sampled_from(SCHEMAS), words_without_marks(), st.integers(0, 2**31))
def test_every_answer_fits_its_schema(
    backend: LlamaCppBackend, schema: dict[str, Any], words: str, seed: int
) -> None:
    """With random weights only the grammar can make it fit, and compact."""
    messages = [ChatMessage(role="user", content=words)]
    request = CompleteRequest(
        messages=messages, schema=schema, seed=seed, temperature=1.0, max_tokens=400
    )
    answer = complete(backend, request, Budget(RealClock(), 60.0))
    jsonschema.validate(answer.value, schema)
    assert json.loads(answer.text) == answer.value
    assert is_compact(answer.text)


def test_the_longest_string_has_a_grammar() -> None:
    assert "{0,4000}" in grammar_of({"type": "string", "maxLength": 4000})


@pytest.mark.parametrize(
    "grammar",
    [
        "root ::= missing",
        'root ::= root "a" | "b"',
        'top ::= "a"',
        "root ::= (",
        "root ::= (([a-z]{0,300}){0,300}){0,300}",
        'root ::= "a\0"',
        "",
        "root ::= " + '"a" ' * 60_000,
    ],
)
def test_a_grammar_that_would_end_the_process_is_refused(grammar: str) -> None:
    with pytest.raises(RefusedError, match="grammar"):
        check_grammar(grammar)


def test_a_schema_too_large_for_llama_cpp_is_refused_and_the_next_is_answered(
    backend: LlamaCppBackend,
) -> None:
    messages = [ChatMessage(role="user", content="x")]
    deep = obj(a={"type": "string", "pattern": "^((a{0,300}){0,300}){0,300}$"})
    with pytest.raises(RefusedError, match=r"llama\.cpp refuses the grammar"):
        complete(
            backend, CompleteRequest(messages=messages, schema=deep), Budget(RealClock(), 60.0)
        )
    small = CompleteRequest(messages=messages, schema={"enum": ["yes"]})
    assert complete(backend, small, Budget(RealClock(), 60.0)).value == "yes"


@pytest.mark.parametrize(
    ("pattern", "rule"),
    [
        ("^ab?$", '"a" "b"?'),
        ("^(a|b)*$", '("a" | "b"){0,7}'),
        ("^(?:a|)b{2,}$", '("a" | "") "b"{2,7}'),
        ("^[^0-9]+$", r'[^0-9"\\\x00-\x1F\x7F]{1,7}'),
        (r"^\d{2}\.$", r'[0-9]{2,2} "."'),
        ("^[]a]$", r"[\x5Da]"),
        (r"^[!-~]{,3}$", r"[\x21\x23-\x5B\x5D-\x7E]{0,3}"),
        ('^"$', r'"\\\""'),
    ],
)
def test_a_pattern_becomes_a_rule(pattern: str, rule: str) -> None:
    assert pattern_rule(pattern, 7) == rule
    check_grammar(f"root ::= {rule}")


@pytest.mark.parametrize(
    "pattern", [r"^(a)\1$", "^(?=a)b$", "^a+?$", "^a)$", r"^\bx$", '^["]$', "^a{x}$", "^\n$"]
)
def test_a_pattern_without_such_a_rule_is_refused(pattern: str) -> None:
    with pytest.raises(RefusedError, match="has no GBNF form"):
        pattern_rule(pattern, 7)


@pytest.mark.filterwarnings("ignore:Possible:FutureWarning")
@settings(max_examples=60)
@given(st.from_regex(r"\A[a-c(){}|?*+\[\]^0-9,.\\-]{0,12}\Z"))
def test_what_python_compiles_either_becomes_a_rule_that_llama_cpp_takes_or_is_refused(
    inner: str,
) -> None:
    try:
        re.compile(inner)
        checked = check_schema({"type": "string", "pattern": f"^{inner}$", "maxLength": 5})
        grammar_of(checked)
    except (re.error, OverflowError, RecursionError, RefusedError):
        return
