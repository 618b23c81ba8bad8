"""Reading gives decoded messages where it can, and the reason where it cannot."""

from contextlib import suppress
from pathlib import Path

import pytest

from support.recordings import MARK_KEY, raw_mark, raw_message, write_recording
from w2c import topics
from w2c.bus import InProcessHub, RawReceived
from w2c.errors import RecordingError, RefusedError
from w2c.messages import CallTrace, LiftReply, LiftRequest, LogRecord, MarkRequest
from w2c_recorder.reading import Recording, decode_call


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "session.mcap"


def test_messages_come_decoded_in_their_order(path: Path) -> None:
    write_recording(path, [raw_mark("a", 0), raw_mark("b", 1)])

    first, second = Recording(path).messages()

    assert isinstance(first.message, MarkRequest)
    assert first.message.text == "a"
    assert first.topic is topics.MARK
    assert first.envelope is not None
    assert first.envelope.sender == "recorder"
    assert second.sequence == 1


def test_a_recording_can_be_read_twice(path: Path) -> None:
    write_recording(path, [raw_mark("a")])
    recording = Recording(path)

    assert len(list(recording.messages())) == len(list(recording.messages())) == 1


def test_rows_select_messages_of_every_writer(path: Path) -> None:
    record = LogRecord(stamp_ns=0, level="info", logger="x", text="hello")
    write_recording(
        path,
        [
            raw_mark("a"),
            raw_message(record, topics.LOG.key("test", "llm"), sender="llm"),
            raw_message(record, topics.LOG.key("test", "robot"), sender="robot"),
        ],
    )

    found = [recorded.key for recorded in Recording(path).of(topics.LOG)]

    assert found == ["w2c/v1/test/log/llm/record", "w2c/v1/test/log/robot/record"]


def test_what_does_not_decode_says_why(path: Path) -> None:
    wrong_type = raw_message(MarkRequest(text="a"), topics.HEALTH.key("test", "llm"))
    foreign = raw_message(MarkRequest(text="a"), "w2c/v1/test/state/nobody/knows")
    write_recording(path, [wrong_type, foreign, RawReceived(MARK_KEY, b"\xc1", 0)])

    health, unknown, garbage = Recording(path).messages()

    assert health.message is None
    assert "not a Health" in health.problem
    assert unknown.topic is None
    assert unknown.envelope is not None
    assert "no such key" in unknown.problem
    assert garbage.envelope is None
    assert "not msgpack" in garbage.problem


def test_lists_in_lists_in_lists_do_not_decode(path: Path) -> None:
    mark = raw_mark("a")
    cut = mark.payload.index(b"\xa4data") + 5
    deep = RawReceived(mark.key, mark.payload[:cut] + b"\x91" * 700 + b"\x90", 0)
    write_recording(path, [deep])

    (recorded,) = Recording(path).messages()

    assert recorded.message is None
    assert "not a MarkRequest" in recorded.problem


def test_a_missing_file_is_an_error_with_its_path(path: Path) -> None:
    with pytest.raises(RecordingError, match=r"no recording at .*session\.mcap"):
        list(Recording(path).messages())


def test_a_directory_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="Is a directory"):
        list(Recording(tmp_path).messages())


def traces_of(hub: InProcessHub, request: LiftRequest, timeout_s: float = 5.0) -> CallTrace:
    """Make one call and return the trace that its caller published."""
    queue = hub.connect("recorder").queue(topics.TRACE)
    caller = hub.connect("dialogue")
    with suppress(RefusedError):
        caller.call(topics.LIFT, request, timeout_s=timeout_s)
    received = queue.receive(5.0)
    assert received is not None
    return received.message


def test_request_and_error_of_a_traced_call_are_decoded() -> None:
    def refuse(_request: LiftRequest, _context: object) -> LiftReply:
        raise RefusedError("the sky has no depth")

    hub = InProcessHub()
    hub.connect("perception").serve(topics.LIFT, refuse)
    trace = traces_of(hub, LiftRequest(u=1.5, v=2.5, frame_stamp_ns=3))

    request, _reply = decode_call(trace)

    assert isinstance(request, LiftRequest)
    assert (request.u, request.v, request.frame_stamp_ns) == (1.5, 2.5, 3)
    assert trace.outcome == "refused"
    assert "the sky has no depth" in trace.error


def test_a_trace_of_an_unknown_method_decodes_to_nothing() -> None:
    trace = CallTrace(
        service="oracle", method="ask", instance="0", outcome="ok", duration_ms=1.0,
        request=b"", reply=b"",
    )  # fmt: skip

    assert decode_call(trace) == (None, None)
