"""Does a value fit a checked schema? Asked of every answer, whatever the backend promised."""

import json
import math
import re
from collections.abc import Callable

from w2c_llm.schema import MAX_STRING, Schema

_MAX_BITS = 1000
"""A longer integer fits no floating-point number: arithmetic on it would fail"""


def violation(value: object, schema: Schema, path: str = "$") -> str | None:
    """Return why a value does not fit a checked schema; None when it does."""
    if "enum" in schema:
        if any(value == option and type(value) is type(option) for option in schema["enum"]):
            return None
        return f"{path} is {_short(value)}, must be one of {_short(schema['enum'])}"
    if "anyOf" in schema:
        reasons = [violation(value, one, path) for one in schema["anyOf"]]
        return None if None in reasons else " or ".join(str(reason) for reason in reasons)
    return _VIOLATIONS[schema["type"]](value, schema, path)


def _short(value: object) -> str:
    text = json.dumps(value, ensure_ascii=False, default=str)
    return text if len(text) <= 120 else text[:117] + "..."


def _object_violation(value: object, schema: Schema, path: str) -> str | None:
    if not isinstance(value, dict):
        return f"{path} is {_short(value)}, must be an object"
    missing = [name for name in schema["required"] if name not in value]
    if missing:
        return f"{path} lacks {', '.join(missing)}"
    for name, item in value.items():
        if name not in schema["properties"]:
            return f"{path} has '{name:.60}', which the schema does not know"
        reason = violation(item, schema["properties"][name], f"{path}.{name}")
        if reason is not None:
            return reason
    return None


def _array_violation(value: object, schema: Schema, path: str) -> str | None:
    if not isinstance(value, list):
        return f"{path} is {_short(value)}, must be an array"
    if not schema["minItems"] <= len(value) <= schema["maxItems"]:
        return (
            f"{path} has {len(value)} items, must have {schema['minItems']} to {schema['maxItems']}"
        )
    for index, item in enumerate(value):
        reason = violation(item, schema["items"], f"{path}[{index}]")
        if reason is not None:
            return reason
    return None


def _string_violation(value: object, schema: Schema, path: str) -> str | None:
    if not isinstance(value, str):
        return f"{path} is {_short(value)}, must be a string"
    low, high = schema.get("minLength", 0), schema.get("maxLength", MAX_STRING)
    if not low <= len(value) <= high:
        return f"{path} has {len(value)} characters, must have {low} to {high}"
    if "pattern" in schema and re.fullmatch(schema["pattern"], value) is None:
        return f"{path} is {_short(value)}, must match {schema['pattern']}"
    return None


def _number_violation(value: object, schema: Schema, path: str) -> str | None:
    kind = schema["type"]
    if isinstance(value, bool) or not isinstance(value, int | float):
        return f"{path} is {_short(value)}, must be a {kind}"
    if isinstance(value, int) and value.bit_length() > _MAX_BITS:
        return f"{path} has {value.bit_length()} bits, must be a {kind} of at most {_MAX_BITS}"
    if not math.isfinite(value) or (kind == "integer" and value != int(value)):
        return f"{path} is {value}, must be a finite {kind}"
    checks: dict[str, Callable[[float, float], bool]] = {
        "minimum": lambda a, b: a >= b,
        "maximum": lambda a, b: a <= b,
        "exclusiveMinimum": lambda a, b: a > b,
        "exclusiveMaximum": lambda a, b: a < b,
        "multipleOf": _is_multiple,
    }
    for name, holds in checks.items():
        if name in schema and not holds(value, schema[name]):
            return f"{path} is {value}, breaks {name} {schema[name]}"
    return None


def _is_multiple(value: float, step: float) -> bool:
    ratio = value / step
    return math.isfinite(ratio) and abs(ratio - round(ratio)) < 1e-9


def _boolean_violation(value: object, _: Schema, path: str) -> str | None:
    return None if isinstance(value, bool) else f"{path} is {_short(value)}, must be true or false"


def _null_violation(value: object, _: Schema, path: str) -> str | None:
    return None if value is None else f"{path} is {_short(value)}, must be null"


_VIOLATIONS: dict[str, Callable[[object, Schema, str], str | None]] = {
    "object": _object_violation,
    "array": _array_violation,
    "string": _string_violation,
    "integer": _number_violation,
    "number": _number_violation,
    "boolean": _boolean_violation,
    "null": _null_violation,
}
