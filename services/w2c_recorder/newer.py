"""Messages that a newer version wrote: what this version knows of them."""

from typing import Any, get_args

import msgspec

from w2c.messages import Message


def known_part(data: Any, message_type: type[Message]) -> tuple[Any, list[str]]:
    """Return decoded data without the fields that a message does not have here, and their names.

    Only structs are looked into, alone or in lists, as the messages hold them.
    """
    unknown: list[str] = []
    return _known(data, message_type, "", unknown), unknown


def _known(value: Any, struct_type: type[msgspec.Struct], path: str, unknown: list[str]) -> Any:
    if isinstance(value, list):
        return [_known(item, struct_type, path, unknown) for item in value]
    if not isinstance(value, dict):
        return value
    fields = {field.encode_name: field.type for field in msgspec.structs.fields(struct_type)}
    kept = {}
    for name, inner in value.items():
        where = f"{path}.{name}" if path else str(name)
        if name not in fields:
            unknown.append(where)
            continue
        inner_type = _struct_in(fields[name])
        kept[name] = inner if inner_type is None else _known(inner, inner_type, where, unknown)
    return kept


def _struct_in(annotation: Any) -> type[msgspec.Struct] | None:
    """Return the struct that an annotation mentions, as in `list[Box]`; None: it mentions none."""
    if isinstance(annotation, type) and issubclass(annotation, msgspec.Struct):
        return annotation
    for argument in get_args(annotation):
        found = _struct_in(argument)
        if found is not None:
            return found
    return None
