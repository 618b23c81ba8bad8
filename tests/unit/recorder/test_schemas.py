"""Schemas describe what is on the wire: every message, its arrays, bytes and units."""

import json
from typing import Any

import jsonschema
import pytest

from w2c import messages as m
from w2c import topics
from w2c_recorder.liveliness import Liveliness
from w2c_recorder.schemas import field_docs, json_schema

RECORDED = [*{topic.message for topic in topics.TOPICS}, Liveliness]


def definition(message_type: type[m.Message]) -> dict[str, Any]:
    schema = json.loads(json_schema(message_type))
    found: dict[str, Any] = schema["$defs"][message_type.__name__]["properties"]
    return found


@pytest.mark.parametrize("message_type", RECORDED, ids=lambda t: t.__name__)
def test_every_recorded_message_has_a_valid_schema_of_its_envelope(
    message_type: type[m.Message],
) -> None:
    schema = json.loads(json_schema(message_type))
    jsonschema.Draft202012Validator.check_schema(schema)

    assert schema["title"] == message_type.__name__
    assert schema["$ref"] == "#/$defs/Envelope"
    assert schema["$defs"]["Envelope"]["properties"]["data"] == {
        "$ref": f"#/$defs/{message_type.__name__}"
    }


def test_a_schema_accepts_its_message_and_refuses_another() -> None:
    validator = jsonschema.Draft202012Validator(json.loads(json_schema(m.MarkRequest)))
    envelope: dict[str, Any] = {
        "version": 1,
        "robot": "test",
        "sender": "recorder",
        "boot_id": "b",
        "sequence": 0,
        "monotonic_ns": 0,
        "clock_ns": 0,
        "inputs": [],
    }

    assert validator.is_valid({**envelope, "data": {"text": "here"}})
    assert not validator.is_valid({**envelope, "data": {"txt": "here"}})
    assert not validator.is_valid({**envelope, "data": {"text": ""}})


def test_arrays_are_described_as_they_are_packed_with_shape_and_unit() -> None:
    position = definition(m.RobotState)["position"]

    assert position["x-msgpack"] == "ext 1"
    assert position["description"].startswith("(n,) [rad]")
    assert "little-endian" in position["description"]


def test_bytes_are_not_called_base64() -> None:
    for message_type in (m.CameraFrame, m.CallTrace):
        assert "base64" not in json_schema(message_type).decode()
    assert definition(m.CameraFrame)["jpeg"]["x-msgpack"] == "bin"


def test_docstrings_of_fields_come_along() -> None:
    assert definition(m.Turn)["seconds"]["description"] == "From the utterance to the answer [s]"


def test_structs_within_structs_are_documented_too() -> None:
    schema = json.loads(json_schema(m.Turn))

    frame = schema["$defs"]["Target"]["properties"]["v"]
    assert frame["description"] == "Pixel in that frame"


def test_a_struct_without_source_has_no_docs_and_still_a_schema() -> None:
    namespace: dict[str, Any] = {"Message": m.Message}
    exec("class Made(Message, frozen=True):\n    x: float\n    'a unit'", namespace)  # noqa: S102

    assert field_docs(namespace["Made"]) == {}
