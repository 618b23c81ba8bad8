"""GBNF, the grammar language of llama.cpp and llama-server, from a checked schema.

The grammar allows compact JSON only, and no more than the schema: strings hold characters that
need no escape, numbers have no exponent. What GBNF cannot say is left to the validation of the
answer: bounds of numbers, and the length of a string that has a pattern too.
"""

import json
from collections.abc import Callable
from typing import Any

import llama_cpp

from w2c.errors import RefusedError
from w2c_llm.gbnf_pattern import PLAIN, literal, pattern_rule
from w2c_llm.schema import MAX_STRING, Schema

ROOT = "root"
_WHOLE = '("0" | [1-9] [0-9]{0,14})'
_LONGEST_GRAMMAR = 200_000


def grammar_of(schema: Schema) -> str:
    """Return the grammar of a checked schema.

    Raises:
        RefusedError: a pattern has no GBNF form, or llama.cpp refuses the grammar.
    """
    text = grammar_text(schema)
    check_grammar(text)
    return text


def grammar_text(schema: Schema) -> str:
    """Return the grammar, not yet tried."""
    rules = _Rules()
    rules.define(ROOT, rules.rule(schema))
    return "\n".join(rules.lines)


def check_grammar(text: str, vocabulary: Any = None) -> None:
    """Raise RefusedError for a grammar that llama.cpp would not take: using it ends the process.

    Args:
        text: In GBNF; its first rule to be read is `root`.
        vocabulary: Of the model that it is for; None: of none.
    """
    if len(text) > _LONGEST_GRAMMAR:
        raise RefusedError(f"a grammar of {len(text)} characters, limit {_LONGEST_GRAMMAR}")
    if not text.strip():
        raise RefusedError("a grammar of nothing would allow everything")
    if "\0" in text:
        raise RefusedError("a grammar holds the character 0, which ends it for llama.cpp")
    sampler = llama_cpp.llama_sampler_init_grammar(vocabulary, text.encode(), ROOT.encode())
    if not sampler:
        raise RefusedError(
            "llama.cpp refuses the grammar of the schema: too large, or a rule is wrong; "
            "use shorter lists and strings, or --constraint llguidance"
        )
    llama_cpp.llama_sampler_free(sampler)


class _Rules:
    """The rules of one grammar; those of objects refer to each other by name."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def define(self, name: str, body: str) -> None:
        """Add a named rule."""
        self.lines.append(f"{name} ::= {body}")

    def rule(self, schema: Schema) -> str:
        """Return the body of a rule for one node of a schema."""
        if "enum" in schema:
            return _alternatives([_json_literal(value) for value in schema["enum"]])
        if "anyOf" in schema:
            return _alternatives([self.rule(one) for one in schema["anyOf"]])
        kinds: dict[str, Callable[[Schema], str]] = {
            "object": self._object,
            "array": self._array,
            "string": _string,
            "integer": _number,
            "number": _number,
            "boolean": lambda _: '("true" | "false")',
            "null": lambda _: '"null"',
        }
        return kinds[schema["type"]](schema)

    def _object(self, schema: Schema) -> str:
        """Return `{` and properties in order; an optional one may be left out."""
        members = [
            (f"{literal(json.dumps(name, ensure_ascii=False) + ':')} {self.rule(node)}", name)
            for name, node in schema["properties"].items()
        ]
        if all(name in schema["required"] for _, name in members):
            inside = ' "," '.join(body for body, _ in members)
            return f'"{{" {inside} "}}"'
        # After each property: what may follow it, with a comma in front, or at the beginning.
        prefix = f"object-{len(self.lines)}"
        self.define(f"{prefix}-{len(members)}-first", '""')
        self.define(f"{prefix}-{len(members)}-then", '""')
        for index in reversed(range(len(members))):
            body, name = members[index]
            for state, comma in (("first", ""), ("then", '"," ')):
                taken = f"{comma}{body} {prefix}-{index + 1}-then"
                skipped = "" if name in schema["required"] else f" | {prefix}-{index + 1}-{state}"
                self.define(f"{prefix}-{index}-{state}", taken + skipped)
        return f'"{{" {prefix}-0-first "}}"'

    def _array(self, schema: Schema) -> str:
        low, high = schema["minItems"], schema["maxItems"]
        if high == 0:
            return '"[]"'
        body = self.rule(schema["items"])
        item = f"item-{len(self.lines)}"
        self.define(item, body)
        more = f'{item} ("," {item}){{{max(low - 1, 0)},{high - 1}}}'
        return f'"[" {more} "]"' if low else f'"[" ({more})? "]"'


def _alternatives(rules: list[str]) -> str:
    return rules[0] if len(rules) == 1 else f"({' | '.join(rules)})"


def _json_literal(value: Any) -> str:
    return literal(json.dumps(value, ensure_ascii=False))


def _string(schema: Schema) -> str:
    low, high = schema.get("minLength", 0), schema.get("maxLength", MAX_STRING)
    if "pattern" in schema:
        inside = f"({pattern_rule(schema['pattern'], high)})"
    else:
        inside = f"{PLAIN}{{{low},{high}}}"
    return rf'"\"" {inside} "\""'


def _number(schema: Schema) -> str:
    least: float = schema["minimum"] if "minimum" in schema else schema.get("exclusiveMinimum", -1)
    sign = "" if least >= 0 else '"-"? '
    fraction = "" if schema["type"] == "integer" else ' ("." [0-9]{1,6})?'
    return f"{sign}{_WHOLE}{fraction}"
