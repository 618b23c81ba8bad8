"""The wire's bytes are written, self-described; nothing is overwritten or half written."""

import json
from pathlib import Path

import pytest
from mcap.reader import make_reader

from support.disk import file_size_limit
from support.recordings import MARK_KEY, raw_mark, raw_message, write_recording
from w2c.bus import RawReceived
from w2c.errors import RecordingError
from w2c.messages import MarkRequest
from w2c_recorder import mcap_file
from w2c_recorder.mcap_file import McapFile, head_of
from w2c_recorder.reading import Recording


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "session.mcap"


def test_the_bytes_of_the_wire_come_back_with_their_times_and_numbers(path: Path) -> None:
    sent = [raw_mark(f"mark {i}", sequence=i, received_ns=5_000 + i) for i in range(3)]
    write_recording(path, sent)

    with path.open("rb") as stream:
        found = [
            (channel.topic, message.data, message.log_time, message.publish_time, message.sequence)
            for _, channel, message in make_reader(stream).iter_messages()
        ]

    assert found == [(MARK_KEY, raw.payload, 5_000 + i, 1_000 + i, i) for i, raw in enumerate(sent)]


def test_a_channel_describes_its_encoding_and_schema(path: Path) -> None:
    write_recording(path, [raw_mark("a")])

    with path.open("rb") as stream:
        schema, channel, _ = next(make_reader(stream).iter_messages())

    assert channel.message_encoding == "msgpack"
    assert schema is not None
    assert (schema.name, schema.encoding) == ("MarkRequest", "jsonschema")
    assert json.loads(schema.data)["title"] == "MarkRequest"


def test_two_keys_of_one_message_share_a_schema(path: Path) -> None:
    other_key = MARK_KEY.replace("test", "other")
    write_recording(path, [raw_mark("a"), raw_message(MarkRequest(text="b"), other_key)])

    with path.open("rb") as stream:
        summary = make_reader(stream).get_summary()

    assert summary is not None
    assert len(summary.channels) == 2
    assert len(summary.schemas) == 1


def test_a_key_that_the_registry_does_not_know_is_recorded_without_a_schema(path: Path) -> None:
    write_recording(path, [RawReceived("w2c/v2/test/odd/one/out", b"\x80", 1)])

    with path.open("rb") as stream:
        schema, channel, message = next(make_reader(stream).iter_messages())

    assert schema is None
    assert channel.topic == "w2c/v2/test/odd/one/out"
    assert message.data == b"\x80"


@pytest.mark.parametrize(
    "payload", [b"\xffgarbage", b"\x81\xa4data" + b"\x91" * 2000 + b"\x90"], ids=["none", "deep"]
)
def test_bytes_that_are_no_envelope_are_recorded_and_counted(path: Path, payload: bytes) -> None:
    garbage = RawReceived(MARK_KEY, payload, 77)
    file = write_recording(path, [garbage])

    assert file.malformed == 1
    (recorded,) = Recording(path).messages()
    assert recorded.payload == garbage.payload
    assert recorded.publish_time_ns == recorded.log_time_ns == 77


def test_more_keys_than_a_file_can_number_are_left_out_and_the_others_go_on(
    path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(mcap_file, "MOST_CHANNELS", 2)
    odd = [RawReceived(f"w2c/v1/test/odd/{number}", b"\x80", 1) for number in range(4)]
    file = write_recording(path, [*odd, odd[0]])

    assert [one.key for one in Recording(path).messages()] == [odd[n].key for n in (0, 1, 0)]
    assert (file.messages, file.left_out) == (3, 2)
    assert caplog.text.count("invents keys") == 1


def test_a_file_that_cannot_even_begin_leaves_nothing(path: Path) -> None:
    with file_size_limit(20), pytest.raises(RecordingError, match="after 20 bytes"):
        McapFile(path, {"robot": "test"})

    assert not path.exists()


def test_stamps_that_mcap_cannot_hold_do_not_stop_the_recording(path: Path) -> None:
    message = raw_message(MarkRequest(text="a"), MARK_KEY, sequence=2**40 + 3)
    file = write_recording(path, [message])

    assert file.messages == 1
    (recorded,) = Recording(path).messages()
    assert recorded.sequence == 3
    assert recorded.envelope is not None
    assert recorded.envelope.sequence == 2**40 + 3


def test_losses_are_in_the_metadata_of_a_closed_file(path: Path) -> None:
    write_recording(path, [raw_mark("a", 0), raw_mark("b", 4)])
    recording = Recording(path)
    list(recording.messages())

    assert recording.metadata["losses"] == {MARK_KEY: "3"}
    assert recording.metadata["session"]["robot"] == "test"


def test_clocks_of_the_senders_are_in_the_metadata_of_a_closed_file(path: Path) -> None:
    write_recording(
        path,
        [raw_message(MarkRequest(text="a"), MARK_KEY, number, sender=sender, boot_id=sender,
                     clock_ns=1_000, received_ns=1_000 + age_ns)
         for number, (sender, age_ns) in enumerate([("llm", 70), ("llm", 50), ("robot", -900)])],
    )  # fmt: skip
    recording = Recording(path)
    list(recording.messages())

    assert recording.metadata["clocks"] == {"llm": "50", "robot": "-900"}


def test_an_existing_file_is_never_written_over(path: Path) -> None:
    path.write_bytes(b"precious")

    with pytest.raises(RecordingError, match="File exists"):
        McapFile(path, {})
    assert path.read_bytes() == b"precious"


def test_a_directory_that_is_missing_is_an_error_with_the_path(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"nowhere/session\.mcap cannot be written"):
        McapFile(tmp_path / "nowhere" / "session.mcap", {})


def test_what_was_flushed_is_readable_while_the_file_is_open(path: Path) -> None:
    file = McapFile(path, {})
    file.write(raw_mark("early"), 1)
    file.flush()
    file.write(raw_mark("late", 1), 2)

    recording = Recording(path)
    texts = [r.message.text for r in recording.messages() if isinstance(r.message, MarkRequest)]
    file.abandon()

    assert texts == ["early"]
    assert not recording.damage.complete


def test_a_full_disk_is_an_error_and_what_came_before_is_readable(path: Path) -> None:
    limit = 200_000
    file = McapFile(path, {}, compression="none")
    text = "x" * 900
    flushed: list[int] = []

    def write_without_end() -> None:
        for sequence in range(limit):
            file.write(raw_mark(text, sequence), sequence)
            if sequence % 10 == 9:
                file.flush()
                flushed.append(sequence)

    with (
        file_size_limit(limit),
        pytest.raises(RecordingError, match="cannot be written any further"),
    ):
        write_without_end()
    file.abandon()

    found = [recorded.sequence for recorded in Recording(path).messages()]
    assert found == list(range(flushed[-1] + 1))
    assert path.stat().st_size <= limit


def test_the_head_is_read_without_the_message() -> None:
    head = head_of(raw_mark("a", sequence=9).payload)

    assert head is not None
    assert (head.boot_id, head.sequence, head.clock_ns) == ("boot", 9, 1_009)
    assert head_of(b"") is None
    assert head_of(b"\x81\xa1a") is None
