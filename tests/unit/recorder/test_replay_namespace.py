"""A recorded message becomes one of another robot, and says the same."""

from typing import Any

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from support.examples import all_examples
from support.recordings import MARK_KEY, raw_mark, raw_message
from w2c import topics
from w2c.bus import Envelope, Input, decode_envelope, encode_envelope
from w2c.bus.codec import encode_message, validate
from w2c.messages import ControllerSnapshot, MarkRequest
from w2c_recorder.replay.namespace import NAMING_BOOTS, Namespace

ROWS = [topic for topic in topics.TOPICS if topic.message.__name__ in all_examples()]


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row.kind}/{row.service}/{row.name}")
def test_every_message_says_the_same(row: topics.Topic[Any]) -> None:
    namespace = Namespace("desk")
    namespace.begin_pass()
    example = all_examples()[row.message.__name__]
    key = row.key("test", "llm" if row.service == "*" else row.service)
    raw = raw_message(example, key, 7, boot_id="0123456789abcdef", clock_ns=12)

    payload = namespace.message(key, raw.payload)

    assert payload is not None
    envelope, before = decode_envelope(payload), decode_envelope(raw.payload)
    assert (envelope.robot, envelope.sequence, envelope.clock_ns) == ("desk", 7, 12)
    assert (envelope.sender, envelope.monotonic_ns) == (before.sender, before.monotonic_ns)
    message = validate(envelope.data, row.message)
    if row not in NAMING_BOOTS:
        assert encode_message(message) == encode_message(validate(before.data, row.message))


def test_the_key_is_the_other_robots() -> None:
    namespace = Namespace("desk")

    assert namespace.key("w2c/v1/talos/state/robot/joints") == "w2c/v1/desk/state/robot/joints"
    assert namespace.key("w2c/v1/talos/rpc/llm/0/choose") == "w2c/v1/desk/rpc/llm/0/choose"
    assert namespace.key("") == ""


def test_what_refers_to_a_message_still_does_and_another_pass_is_another_start() -> None:
    namespace = Namespace("desk")
    namespace.begin_pass()
    source = Input(key=topics.ROBOT_STATE.key("test"), boot_id="robot-boot", sequence=5)
    answer = raw_message(MarkRequest(text="a"), MARK_KEY, inputs=[source], boot_id="recorder-boot")
    passes = []
    for _ in range(2):
        namespace.begin_pass()
        payload = namespace.message(MARK_KEY, answer.payload)
        assert payload is not None
        envelope = decode_envelope(payload)
        (reference,) = envelope.inputs
        assert reference.key == topics.ROBOT_STATE.key("desk")
        assert reference.boot_id == namespace.boot_id("robot-boot")
        assert reference.sequence == 5
        assert envelope.boot_id == namespace.boot_id("recorder-boot") != reference.boot_id
        passes.append(reference.boot_id)

    assert passes[0] != passes[1]
    assert all(namespace.is_own(boot_id) for boot_id in passes)
    assert not namespace.is_own("robot-boot")
    assert Namespace("desk").boot_id("robot-boot") not in passes


def test_boot_ids_inside_of_messages_go_with_them() -> None:
    namespace = Namespace("desk")
    namespace.begin_pass()
    example = all_examples()["ControllerSnapshot"]
    assert isinstance(example, ControllerSnapshot)
    assert example.robot_boot_id
    key = topics.CONTROLLER_SNAPSHOT.key("test")

    payload = namespace.message(key, raw_message(example, key).payload)

    assert payload is not None
    message = validate(decode_envelope(payload).data, ControllerSnapshot)
    assert message.robot_boot_id == namespace.boot_id(example.robot_boot_id)
    assert message.controller_boot_id == namespace.boot_id(example.controller_boot_id)
    rest = msgspec.structs.replace(
        message,
        robot_boot_id=example.robot_boot_id,
        controller_boot_id=example.controller_boot_id,
    )
    assert encode_message(rest) == encode_message(example)


def test_rows_that_name_boots_are_found_in_the_registry() -> None:
    assert {topics.CAMERA_FRAME, topics.CAMERA_VIEW, topics.CONTROLLER_SNAPSHOT} <= NAMING_BOOTS
    assert topics.ROBOT_STATE not in NAMING_BOOTS


def test_an_envelope_of_another_version_is_none() -> None:
    newer = Envelope(
        version=2, robot="test", sender="x", boot_id="b", sequence=0, monotonic_ns=0, clock_ns=0,
        inputs=[], data=MarkRequest(text="a"),
    )  # fmt: skip

    assert Namespace("desk").message(MARK_KEY, encode_envelope(newer)) is None


def test_fields_of_a_newer_message_stay() -> None:
    payload = Namespace("desk").message(MARK_KEY, raw_mark("a").payload.replace(b"text", b"texx"))

    assert payload is not None
    assert decode_envelope(payload).data == {"texx": "a"}


@given(st.binary(max_size=60))
def test_bytes_that_are_no_envelope_are_none(payload: bytes) -> None:
    assert Namespace("desk").message(MARK_KEY, payload) is None


def test_lists_in_lists_without_an_end_are_none() -> None:
    deep = b"\x81\xa4data" + b"\x91" * 2000 + b"\x90"

    assert Namespace("desk").message(MARK_KEY, deep) is None
