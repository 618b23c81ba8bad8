"""Schemas are refused with a reason, or bound every answer; values are checked without trust."""

import math
from typing import Any

import jsonschema
import pytest
from hypothesis import given
from hypothesis import strategies as st

from w2c.errors import RefusedError
from w2c_llm.schema import check_schema
from w2c_llm.values import violation


def obj(**properties: Any) -> dict[str, Any]:
    return {"type": "object", "properties": properties, "required": list(properties)}


UNSUPPORTED = [
    ({"type": "string"}, "maxLength"),
    ({"type": "string", "maxLength": 10**6}, "maxLength"),
    ({"type": "string", "pattern": "^[a-z]+$"}, "any length"),
    ({"type": "string", "pattern": "^a{3,}$"}, "any length"),
    ({"type": "string", "pattern": "[a-z]{1,3}"}, "begin with"),
    ({"type": "string", "pattern": "^([a-z]$"}, "unterminated|missing"),
    ({"type": "string", "pattern": "^a|b$"}, "outside brackets"),
    ({"type": "array", "items": {"type": "null"}}, "maxItems"),
    ({"type": "array", "maxItems": 2}, "expected an object"),
    (obj(a={"type": "text"}), r"\$\.a"),
    ({**obj(), "additionalProperties": True}, "additionalProperties"),
    ({"type": "object", "required": ["ghost"]}, "required"),
    ({"type": "number", "minimum": math.inf}, "finite"),
    ({"type": "number", "multipleOf": 0}, "above 0"),
    ({"type": "object", "required": [{}]}, "required"),
    ({"not": {"type": "null"}}, "type None"),
    ({"type": "integer", "format": "int32"}, "format"),
    ({"enum": []}, "enum"),
    ({"enum": [[1]]}, "enum"),
    ({"$ref": "https://example.org/schema"}, "ref"),
    ({"$ref": "#/$defs/self", "$defs": {"self": {"$ref": "#/$defs/self"}}}, "deeper"),
    ({"anyOf": []}, "anyOf"),
    ({}, "type None"),
]


@pytest.mark.parametrize(("schema", "reason"), UNSUPPORTED)
def test_a_schema_that_is_unbounded_or_unsupported_is_refused(
    schema: dict[str, Any], reason: str
) -> None:
    with pytest.raises(RefusedError, match=reason):
        check_schema(schema)


def test_references_that_multiply_are_refused() -> None:
    """Ten levels of ten references each would be ten thousand million nodes."""
    definitions: dict[str, Any] = {"l0": {"type": "null"}}
    for level in range(1, 10):
        definitions[f"l{level}"] = obj(
            **{f"p{index}": {"$ref": f"#/$defs/l{level - 1}"} for index in range(10)}
        )
    with pytest.raises(RefusedError, match="nodes"):
        check_schema({"$ref": "#/$defs/l9", "$defs": definitions})


def test_references_are_replaced_and_objects_closed() -> None:
    schema = {
        "$defs": {"side": {"enum": ["left", "right"]}},
        **obj(side={"$ref": "#/$defs/side"}),
    }
    assert check_schema(schema) == {
        "type": "object",
        "properties": {"side": {"enum": ["left", "right"]}},
        "required": ["side"],
        "additionalProperties": False,
    }


def test_the_characters_of_a_class_are_not_operators() -> None:
    pattern = r"^[a-z0-9.+*/()\[\]|-]{1,60}$"
    assert check_schema({"type": "string", "pattern": pattern})["pattern"] == pattern


EXAMPLES: list[dict[str, Any]] = [
    obj(a={"type": "string", "maxLength": 3}, b={"type": "boolean"}),
    obj(a={"type": "string", "maxLength": 9, "minLength": 2, "pattern": "^[0-9-]*$"}),
    obj(a={"type": "integer", "minimum": 0, "maximum": 9}, b={"type": "null"}),
    {"type": "array", "items": {"type": "number", "exclusiveMaximum": 2}, "maxItems": 2},
    {"anyOf": [{"type": "null"}, {"enum": ["x", 1, True]}]},
]
values = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-3, 12)
    | st.floats(allow_nan=False)
    | st.text("0-ax", max_size=4),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from("abc"), inner),
    max_leaves=6,
)


@given(schema=st.sampled_from(EXAMPLES), value=values)
def test_the_verdict_is_that_of_a_full_validator(schema: dict[str, Any], value: Any) -> None:
    """Except for infinity, which JSON does not have."""
    checked = check_schema(schema)
    expected = jsonschema.Draft202012Validator(checked).is_valid(value)
    if isinstance(value, list) and any(isinstance(v, float) and math.isinf(v) for v in value):
        expected = False
    assert (violation(value, checked) is None) == expected


@given(value=st.floats() | st.integers())
def test_a_number_that_is_not_finite_is_no_number(value: float) -> None:
    assert (violation(value, {"type": "number"}) is None) == math.isfinite(value)


@pytest.mark.parametrize(("value", "fits"), [(0.3, True), (0.35, False), (1e308, False)])
def test_multiples_of_a_tiny_step_do_not_overflow(value: float, fits: bool) -> None:
    step = 1e-300 if value > 1e300 else 0.1
    assert (violation(value, {"type": "number", "multipleOf": step}) is None) == fits


def test_the_reason_names_the_place() -> None:
    schema = check_schema(
        obj(list={"type": "array", "maxItems": 3, "items": obj(n={"type": "null"})})
    )
    assert violation({"list": [{"n": None}, {"n": 3}]}, schema) == "$.list[1].n is 3, must be null"
