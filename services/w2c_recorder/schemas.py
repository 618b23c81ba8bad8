"""JSON schemas of the messages, so that a recording describes itself: fields, units, packing."""

import ast
import inspect
import textwrap
from functools import cache
from typing import Any, get_args

import msgspec
import numpy as np

from w2c.bus.codec import ARRAY_EXTENSION, Envelope
from w2c.messages import Message

ARRAY_SCHEMA = {
    "description": (
        f"n-dimensional array, as msgpack extension type {ARRAY_EXTENSION}: one byte length of the "
        "dtype name, one byte number of dimensions, each dimension as little-endian uint32, the "
        "dtype name (numpy's array-interface string such as <f8), then the elements, "
        "little-endian, last dimension fastest"
    ),
    "x-msgpack": f"ext {ARRAY_EXTENSION}",
}
BYTES_SCHEMA = {"description": "bytes, as msgpack bin", "x-msgpack": "bin"}


def json_schema(message_type: type[Message]) -> bytes:
    """Return the JSON schema of what a channel holds: the envelope with this message as data."""
    return msgspec.json.encode(_schema(message_type), order="deterministic")


def same_schema(recorded: bytes, message_type: type[Message]) -> bool:
    """Tell whether a recorded schema has the same fields and types; words do not count."""
    try:
        return bool(_undescribed(msgspec.json.decode(recorded)) == _plain_schema(message_type))
    except (msgspec.DecodeError, UnicodeDecodeError):
        return False


@cache
def _plain_schema(message_type: type[Message]) -> Any:
    return _undescribed(msgspec.json.decode(json_schema(message_type)))


def _undescribed(node: Any) -> Any:
    if isinstance(node, list):
        return [_undescribed(item) for item in node]
    if not isinstance(node, dict):
        return node
    # A property may be called "description": its schema is a dictionary, a description is not.
    return {
        name: _undescribed(value)
        for name, value in node.items()
        if not (name == "description" and isinstance(value, str))
    }


@cache
def _schema(message_type: type[Message]) -> dict[str, Any]:
    (envelope, message), definitions = msgspec.json.schema_components(
        (Envelope, message_type), schema_hook=_array_schema
    )
    for struct_type in _struct_types(message_type, {Envelope, *_struct_types_of(Envelope)}):
        if struct_type.__name__ in definitions:
            _add_field_docs(definitions[struct_type.__name__], struct_type)
    definitions["Envelope"]["properties"]["data"] = message
    schema = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": message_type.__name__,
        **envelope,
        "$defs": definitions,
    }
    described: dict[str, Any] = _describe_bytes(schema)
    return described


def _array_schema(annotated_type: type) -> dict[str, Any]:
    """Describe the one type that msgspec does not know."""
    if annotated_type is np.ndarray:
        return dict(ARRAY_SCHEMA)
    raise NotImplementedError(f"no JSON schema for {annotated_type}")


def _describe_bytes(node: Any) -> Any:
    """Replace msgspec's base64 strings: on this wire bytes are bytes."""
    if isinstance(node, list):
        return [_describe_bytes(item) for item in node]
    if not isinstance(node, dict):
        return node
    if node.get("contentEncoding") == "base64":
        kept = {name: node[name] for name in ("description", "default") if name in node}
        return {**BYTES_SCHEMA, **kept}
    return {name: _describe_bytes(value) for name, value in node.items()}


def _struct_types(struct_type: type, found: set[type]) -> set[type]:
    """Add a struct and every struct within it to `found`, and return it."""
    if struct_type not in found:
        found.add(struct_type)
        for inner in _struct_types_of(struct_type):
            _struct_types(inner, found)
    return found


def _struct_types_of(struct_type: type) -> list[type]:
    """Return the struct types that the fields of a struct mention."""
    pending = [field.type for field in msgspec.structs.fields(struct_type)]
    found = []
    while pending:
        annotation = pending.pop()
        if isinstance(annotation, type) and issubclass(annotation, msgspec.Struct):
            found.append(annotation)
        pending.extend(get_args(annotation))
    return found


def _add_field_docs(definition: dict[str, Any], struct_type: type) -> None:
    """Put the docstrings of fields, which hold units and frames, into a struct's definition."""
    for name, doc in field_docs(struct_type).items():
        field = definition.get("properties", {}).get(name)
        if field is None:
            continue
        packing = f" ({field['description']})" if "x-msgpack" in field else ""
        field["description"] = doc + packing


@cache
def field_docs(struct_type: type) -> dict[str, str]:
    """Return field -> docstring, read from the source: Python keeps no docstrings of fields.

    Empty where there is no source, as in a frozen program: units are then missing from the schema,
    nothing else.
    """
    try:
        source = textwrap.dedent(inspect.getsource(struct_type))
    except (OSError, TypeError):
        return {}
    (definition,) = ast.parse(source).body
    if not isinstance(definition, ast.ClassDef):
        return {}
    docs = {}
    for field, following in zip(definition.body, definition.body[1:], strict=False):
        if (
            isinstance(field, ast.AnnAssign)
            and isinstance(field.target, ast.Name)
            and isinstance(following, ast.Expr)
            and isinstance(following.value, ast.Constant)
            and isinstance(following.value.value, str)
        ):
            docs[field.target.id] = inspect.cleandoc(following.value.value)
    return docs
