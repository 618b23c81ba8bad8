"""The part of JSON schema that a model may be asked for: closed, bounded, not recursive.

What passes here is safe to give to a grammar compiler, and has answers of bounded length only.
"""

import math
import re
from collections.abc import Callable
from typing import Any

from w2c.errors import RefusedError
from w2c_llm.bound_strings import ARITHMETIC_OF, KEYWORDS, WORDS_OF, bound_string

MAX_DEPTH = 12
MAX_NODES = 1000
MAX_STRING = 4000
MAX_ITEMS = 256
MAX_PATTERN = 300

_COMMON = {"title", "description", "default", "$defs", "type"}
_KEYWORDS = {
    "object": {"properties", "required", "additionalProperties"},
    "array": {"items", "minItems", "maxItems"},
    "string": {"minLength", "maxLength", "pattern", *KEYWORDS},
    "integer": {"minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum"},
    "number": {"minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum", "multipleOf"},
    "boolean": set(),
    "null": set(),
}
Schema = dict[str, Any]


def check_schema(schema: Schema) -> Schema:
    """Return an equivalent schema without references, each object closed.

    Raises:
        RefusedError: it is no schema, uses what is not supported, or allows answers of any length.
    """
    definitions = schema.get("$defs", {})
    if not isinstance(definitions, dict):
        raise _refuse("$", "$defs must be an object")
    return _Checker(definitions).check(schema, "$", 0)


def _refuse(path: str, reason: str) -> RefusedError:
    return RefusedError(f"schema at {path}: {reason}")


class _Checker:
    """Walks one schema; counts what it has seen, so that references cannot blow it up."""

    def __init__(self, definitions: Schema) -> None:
        self._definitions = definitions
        self._nodes = 0

    def check(self, node: object, path: str, depth: int) -> Schema:
        """Return the checked copy of one node."""
        self._nodes += 1
        if depth > MAX_DEPTH or self._nodes > MAX_NODES:
            raise _refuse(path, f"deeper than {MAX_DEPTH} levels or more than {MAX_NODES} nodes")
        if not isinstance(node, dict):
            raise _refuse(path, f"expected an object, got {node!r:.60}")
        if "$ref" in node:
            return self.check(self._resolve(node["$ref"], path), path, depth + 1)
        if "enum" in node or "const" in node:
            return {"enum": _checked_enum(node, path)}
        for keyword in ("anyOf", "oneOf"):
            if keyword in node:
                return {"anyOf": self._alternatives(node, keyword, path, depth)}
        kind = node.get("type")
        if not isinstance(kind, str) or kind not in _KEYWORDS:
            raise _refuse(path, f"type {kind!r} is not one of {', '.join(_KEYWORDS)}")
        unknown = sorted(set(node) - _KEYWORDS[kind] - _COMMON)
        if unknown:
            raise _refuse(path, f"{', '.join(unknown)} is not supported for {kind}")
        checkers: dict[str, Callable[[Schema, str, int], Schema]] = {
            "object": self._object,
            "array": self._array,
            "string": _checked_string,
        }
        return checkers.get(kind, _checked_number)(node, path, depth)

    def _resolve(self, reference: object, path: str) -> object:
        prefix = "#/$defs/"
        if not isinstance(reference, str) or not reference.startswith(prefix):
            raise _refuse(path, f"$ref {reference!r:.60} does not begin with {prefix}")
        name = reference.removeprefix(prefix)
        if name not in self._definitions:
            raise _refuse(path, f"$ref to '{name:.60}', which $defs does not hold")
        return self._definitions[name]

    def _alternatives(self, node: Schema, keyword: str, path: str, depth: int) -> list[Schema]:
        alternatives = node[keyword]
        if not isinstance(alternatives, list) or not alternatives:
            raise _refuse(path, f"{keyword} must be a list with at least one schema")
        return [
            self.check(one, f"{path}.{keyword}[{index}]", depth + 1)
            for index, one in enumerate(alternatives)
        ]

    def _object(self, node: Schema, path: str, depth: int) -> Schema:
        properties = node.get("properties", {})
        required = node.get("required", [])
        if not isinstance(properties, dict) or not all(
            isinstance(name, str) for name in properties
        ):
            raise _refuse(path, "properties must be an object")
        if not isinstance(required, list) or not all(
            isinstance(name, str) and name in properties for name in required
        ):
            raise _refuse(path, f"required {required!r:.80} must be a list of declared properties")
        if node.get("additionalProperties", False) is not False:
            raise _refuse(
                path, "additionalProperties must be false: the answer would have no bound"
            )
        return {
            "type": "object",
            "properties": {
                name: self.check(value, f"{path}.{name}", depth + 1)
                for name, value in properties.items()
            },
            "required": list(required),
            "additionalProperties": False,
        }

    def _array(self, node: Schema, path: str, depth: int) -> Schema:
        low = _bound(node, "minItems", 0, MAX_ITEMS, path, default=0)
        if "maxItems" not in node:
            raise _refuse(path, f"an array needs maxItems (at most {MAX_ITEMS})")
        high = _bound(node, "maxItems", low, MAX_ITEMS, path, default=0)
        items = self.check(node.get("items"), f"{path}[]", depth + 1)
        return {"type": "array", "items": items, "minItems": low, "maxItems": high}


def _bound(node: Schema, name: str, low: int, high: int, path: str, *, default: int) -> int:
    value = node.get(name, default)
    if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
        raise _refuse(path, f"{name} is {value!r:.40}, must be an integer from {low} to {high}")
    return value


def _checked_enum(node: Schema, path: str) -> list[Any]:
    values = node["enum"] if "enum" in node else [node["const"]]
    if not isinstance(values, list) or not 1 <= len(values) <= MAX_ITEMS:
        raise _refuse(path, f"enum must be a list of 1 to {MAX_ITEMS} values")
    for value in values:
        if not isinstance(value, str | int | float | bool | None) or len(str(value)) > MAX_STRING:
            raise _refuse(
                path, f"{value!r:.60} of an enum is no short string, number, boolean or null"
            )
        if isinstance(value, float) and not math.isfinite(value):
            raise _refuse(path, f"{value} of an enum is not finite")
    return list(values)


def _checked_string(node: Schema, path: str, _: int) -> Schema:
    if WORDS_OF in node or ARITHMETIC_OF in node:
        return bound_string(node, path)
    low = _bound(node, "minLength", 0, MAX_STRING, path, default=0)
    checked: Schema = {"type": "string"}
    if low:
        checked["minLength"] = low
    if "maxLength" in node:
        checked["maxLength"] = _bound(node, "maxLength", low, MAX_STRING, path, default=0)
    if "pattern" in node:
        checked["pattern"] = _checked_pattern(node["pattern"], path, bounded="maxLength" in node)
    elif "maxLength" not in node:
        raise _refuse(path, "a string needs maxLength, enum or pattern, or it may never end")
    return checked


def _checked_pattern(pattern: object, path: str, *, bounded: bool) -> str:
    if not isinstance(pattern, str) or len(pattern) > MAX_PATTERN:
        raise _refuse(path, f"pattern must be a string of at most {MAX_PATTERN} characters")
    if not (pattern.startswith("^") and pattern.endswith("$")):
        raise _refuse(path, f"pattern '{pattern}' must begin with ^ and end with $")
    try:
        re.compile(pattern)
    except (re.error, RecursionError, OverflowError) as error:
        raise _refuse(path, f"pattern '{pattern}': {error}") from error
    skeleton = _skeleton(pattern)
    if not bounded and re.search(r"[*+]|\{\d*,\}", skeleton):
        raise _refuse(path, f"pattern '{pattern}' matches strings of any length; add maxLength")
    if _has_top_level_alternative(skeleton):
        raise _refuse(
            path, f"pattern '{pattern}' has | outside brackets, where ^ and $ bind closer"
        )
    return pattern


def _skeleton(pattern: str) -> str:
    """Return a pattern without escapes and character classes: only its operators matter here."""
    without_escapes = re.sub(r"\\.", "x", pattern, flags=re.DOTALL)
    return re.sub(r"\[\^?\]?[^\]]*\]", "x", without_escapes)


def _has_top_level_alternative(skeleton: str) -> bool:
    depth = 0
    for character in skeleton:
        depth += (character == "(") - (character == ")")
        if character == "|" and depth == 0:
            return True
    return False


def _checked_number(node: Schema, path: str, _: int) -> Schema:
    """Check a number; booleans and null have no keywords at all."""
    kind = node["type"]
    checked: Schema = {"type": kind}
    for name in sorted(_KEYWORDS[kind] & set(node)):
        value = node[name]
        if (
            not isinstance(value, int | float)
            or isinstance(value, bool)
            or not math.isfinite(value)
        ):
            raise _refuse(path, f"{name} is {value!r:.40}, must be a finite number")
        if name == "multipleOf" and value <= 0:
            raise _refuse(path, f"multipleOf is {value}, must be above 0")
        checked[name] = value
    return checked
