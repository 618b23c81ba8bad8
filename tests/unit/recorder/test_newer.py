"""Of what a newer version wrote, this one reads what it knows, and says what it left out."""

from pathlib import Path

import msgspec
import pytest

from support.recordings import raw_message, write_recording
from w2c import messages as m
from w2c import topics
from w2c.messages import MarkRequest
from w2c_recorder.newer import known_part
from w2c_recorder.reading import Recording
from w2c_recorder.schemas import json_schema, same_schema


class NewerMark(m.Message, frozen=True, kw_only=True):
    """A mark of next year."""

    text: str
    colour: str


def test_unknown_fields_go_at_every_depth() -> None:
    data = {
        "text": "on the book",
        "mood": "calm",
        "target": {"u": 1.0, "boxes": [{"left": 0.0, "depth": 2.0}]},
        "steps": {"selector": 0.1},
    }

    known, unknown = known_part(data, m.Turn)

    assert known == {
        "text": "on the book",
        "target": {"u": 1.0, "boxes": [{"left": 0.0}]},
        "steps": {"selector": 0.1},
    }
    assert unknown == ["mood", "target.boxes.depth"]


def test_what_is_known_of_a_newer_message_is_read(tmp_path: Path) -> None:
    newer = NewerMark(text="it wobbled", colour="red")
    write_recording(tmp_path / "a.mcap", [raw_message(newer, topics.MARK.key("test"))])

    (recorded,) = Recording(tmp_path / "a.mcap").messages()

    assert isinstance(recorded.message, MarkRequest)
    assert recorded.message.text == "it wobbled"
    assert recorded.problem == "fields of a newer version left out: colour"


def test_a_schema_differs_by_its_fields_and_not_by_its_words() -> None:
    schema = msgspec.json.decode(json_schema(MarkRequest))
    schema["description"] = "other words"
    reworded = msgspec.json.encode(schema)
    schema["$defs"]["MarkRequest"]["properties"]["colour"] = {"type": "string"}

    assert same_schema(reworded, MarkRequest)
    assert not same_schema(msgspec.json.encode(schema), MarkRequest)
    assert not same_schema(b"no JSON", MarkRequest)


def test_a_channel_that_another_version_described_is_named(tmp_path: Path) -> None:
    write_recording(tmp_path / "a.mcap", [raw_message(MarkRequest(text="a"), "w2c/v1/t/x/y/z")])
    recording = Recording(tmp_path / "a.mcap")
    list(recording.messages())

    assert recording.other_schemas() == {}


@pytest.mark.parametrize("torn", [b"{", b'{"title": "\xff"}'])
def test_a_schema_that_is_torn_is_another(torn: bytes) -> None:
    assert not same_schema(torn, MarkRequest)
