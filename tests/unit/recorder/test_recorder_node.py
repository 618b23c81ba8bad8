"""The recorder on a bus: what it records, how it is commanded, what it reports."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from unittest.mock import patch

import pytest

from support.recordings import raw_mark
from support.waiting import wait_until
from w2c import topics
from w2c.bus import InProcessBus, InProcessHub
from w2c.clock import RealClock
from w2c.errors import ConfigError, RefusedError
from w2c.messages import (
    Empty,
    Health,
    LiftReply,
    LiftRequest,
    MarkRequest,
    RecorderStatus,
    RecordRequest,
    RobotDescription,
)
from w2c_recorder.config import RecorderConfig
from w2c_recorder.liveliness import Liveliness
from w2c_recorder.mcap_file import McapFile
from w2c_recorder.node import RecorderNode, next_path
from w2c_recorder.overview import overview_of
from w2c_recorder.reading import Recording


@contextmanager
def recorder(hub: InProcessHub, directory: Path | str, **options: Any) -> Iterator[InProcessBus]:
    """Run a recorder; yields the bus of an operator."""
    config = RecorderConfig(
        robot="test", run_directory=str(directory), **{"minimum_free_mb": 0.0, **options}
    )
    stop = threading.Event()
    with hub.connect("recorder") as bus, hub.connect("operator") as operator:
        node = RecorderNode(config, bus, RealClock())
        node.configure()
        thread = threading.Thread(target=node.run, args=(stop,))
        thread.start()
        try:
            yield operator
        finally:
            stop.set()
            thread.join()
            node.close()


@pytest.fixture
def hub() -> InProcessHub:
    return InProcessHub()


def keys(path: Path) -> set[str]:
    return {recorded.key for recorded in Recording(path).messages()}


def health(service: str, detail: str = "") -> Health:
    return Health(
        stamp_ns=1, service=service, instance="0", phase="ready", detail=detail, pid=1,
        cpu_percent=0.0, memory_mb=1.0,
    )  # fmt: skip


def status_of(operator: InProcessBus) -> RecorderStatus:
    return operator.call(topics.RECORD_STATUS, Empty()).message


def test_streams_calls_and_liveliness_are_all_recorded(hub: InProcessHub, tmp_path: Path) -> None:
    def refuse(_request: LiftRequest, _context: object) -> LiftReply:
        raise RefusedError("sky")

    with (
        recorder(hub, tmp_path),
        hub.connect("llm") as llm,
        hub.connect("perception") as perception,
    ):
        perception.serve(topics.LIFT, refuse)
        llm.publish(topics.HEALTH, health("llm"))
        with pytest.raises(RefusedError):
            llm.call(topics.LIFT, LiftRequest(u=0, v=0, frame_stamp_ns=0))

    found = keys(tmp_path / "session.mcap")
    assert {
        "w2c/v1/test/health/llm/status",
        "w2c/v1/test/trace/llm/call",
        "w2c/v1/test/state/recorder/status",
        "w2c/v1/test/live/recorder/0",
    } <= found


def test_every_message_of_a_sender_is_recorded_in_its_order(
    hub: InProcessHub, tmp_path: Path
) -> None:
    with recorder(hub, tmp_path), hub.connect("llm") as llm:
        for number in range(1000):
            llm.publish(topics.HEALTH, health("llm", detail=str(number)))

    found = Recording(tmp_path / "session.mcap").of(topics.HEALTH)
    assert [r.message.detail for r in found if isinstance(r.message, Health)] == [
        str(number) for number in range(1000)
    ]


def test_a_mark_is_in_the_recording(hub: InProcessHub, tmp_path: Path) -> None:
    with recorder(hub, tmp_path) as operator:
        operator.call(topics.RECORD_MARK, MarkRequest(text="it wobbled"))
        operator.call(topics.RECORD_STOP, Empty())

    (mark,) = Recording(tmp_path / "session.mcap").of(topics.MARK)
    assert isinstance(mark.message, MarkRequest)
    assert mark.message.text == "it wobbled"


def test_a_mark_without_a_recording_is_refused(hub: InProcessHub, tmp_path: Path) -> None:
    with (
        recorder(hub, tmp_path, autostart=False) as operator,
        pytest.raises(RefusedError, match="w2c record start"),
    ):
        operator.call(topics.RECORD_MARK, MarkRequest(text="x"))


def test_the_status_is_published_and_true(hub: InProcessHub, tmp_path: Path) -> None:
    with hub.connect("console") as console, recorder(hub, tmp_path):
        received = console.latest(topics.RECORDER_STATUS).wait(5.0)

    assert received is not None
    assert received.message.recording
    assert received.message.path == str(tmp_path / "session.mcap")


def test_losses_reach_the_status(hub: InProcessHub, tmp_path: Path) -> None:
    with recorder(hub, tmp_path) as operator:
        hub.deliver(raw_mark("first", sequence=0))
        hub.deliver(raw_mark("much later", sequence=5))
        wait_until(lambda: status_of(operator).lost != {})
        lost = status_of(operator).lost

    assert lost == {"w2c/v1/test/event/recorder/mark": 4}


def test_stop_and_start_make_a_new_file(hub: InProcessHub, tmp_path: Path) -> None:
    with recorder(hub, tmp_path) as operator:
        stopped = operator.call(topics.RECORD_STOP, Empty()).message
        started = operator.call(topics.RECORD_START, RecordRequest()).message

    assert (stopped.recording, started.recording) == (False, True)
    assert started.path == str(tmp_path / "session-1.mcap")
    for name in ("session.mcap", "session-1.mcap"):
        recording = Recording(tmp_path / name)
        list(recording.messages())
        assert recording.damage.complete


def test_each_file_begins_with_who_is_alive(hub: InProcessHub, tmp_path: Path) -> None:
    with hub.connect("llm"), recorder(hub, tmp_path) as operator:
        operator.call(topics.RECORD_STOP, Empty())
        operator.call(topics.RECORD_START, RecordRequest())
        status = operator.latest(topics.RECORDER_STATUS)
        status.wait(5.0)
        status.wait(5.0)

    messages = [r.message for r in Recording(tmp_path / "session-1.mcap").messages()]
    alive = {m.service for m in messages if isinstance(m, Liveliness) and m.alive}
    assert {"llm", "recorder", "operator"} <= alive


def test_no_autostart_waits_for_the_operator(hub: InProcessHub, tmp_path: Path) -> None:
    with recorder(hub, tmp_path, autostart=False) as operator:
        assert not status_of(operator).recording
        assert list(tmp_path.iterdir()) == []
        assert operator.call(topics.RECORD_START, RecordRequest()).message.recording


def test_autostart_needs_a_run_directory(hub: InProcessHub) -> None:
    with hub.connect("recorder") as bus:
        node = RecorderNode(RecorderConfig(robot="test"), bus, RealClock())
        with pytest.raises(ConfigError, match="--run-directory"):
            node.configure()
        node.close()


@pytest.mark.parametrize(
    ("wanted", "reason"),
    [("notes.txt", r"does not end in \.mcap"), ("session.mcap", "never written over")],
)
def test_a_path_that_is_none_is_refused(
    hub: InProcessHub, tmp_path: Path, wanted: str, reason: str
) -> None:
    with recorder(hub, tmp_path) as operator:
        operator.call(topics.RECORD_STOP, Empty())
        with pytest.raises(RefusedError, match=reason):
            operator.call(topics.RECORD_START, RecordRequest(path=wanted))


def test_without_a_run_directory_a_start_needs_a_path(hub: InProcessHub, tmp_path: Path) -> None:
    with recorder(hub, "", autostart=False) as operator:
        with pytest.raises(RefusedError, match="--path"):
            operator.call(topics.RECORD_START, RecordRequest())
        path = tmp_path / "mine.mcap"
        assert operator.call(topics.RECORD_START, RecordRequest(path=str(path))).message.recording


def test_a_directory_that_cannot_be_written_leaves_the_recorder_alive_and_loud(
    hub: InProcessHub, tmp_path: Path
) -> None:
    """Also root cannot make a directory below a file."""
    (tmp_path / "file").write_text("")
    with recorder(hub, tmp_path / "file" / "run") as operator:
        status = status_of(operator)

    assert not status.recording
    assert "cannot be written" in status.error


def test_a_file_left_by_a_killed_recorder_is_recovered_and_the_next_one_begun(
    hub: InProcessHub, tmp_path: Path
) -> None:
    killed = McapFile(tmp_path / "session.mcap", {})
    killed.write(raw_mark("before the crash"), 1)
    killed.flush()
    killed.abandon()

    with recorder(hub, tmp_path) as operator:
        assert status_of(operator).path == str(tmp_path / "session-1.mcap")

    recovered = Recording(tmp_path / "session.mcap")
    assert [recorded.sequence for recorded in recovered.messages()] == [0]
    assert recovered.damage.complete


def test_next_path_counts_on(tmp_path: Path) -> None:
    for name in ("session.mcap", "session-1.mcap", "session-2.mcap"):
        path = next_path(tmp_path)
        path.touch()

        assert path.name == name


def test_the_robot_is_asked_what_it_is_like(hub: InProcessHub, tmp_path: Path) -> None:
    asked = threading.Event()

    def describe(_request: Empty, _context: object) -> RobotDescription:
        asked.set()
        raise RefusedError("not now")

    with hub.connect("robot") as robot:
        robot.serve(topics.DESCRIBE, describe)
        with (
            patch("w2c_recorder.node.LOOKS_BEFORE_ASKING", 1),
            recorder(hub, tmp_path),
        ):
            assert asked.wait(5.0)

    assert "w2c/v1/test/trace/recorder/call" in keys(tmp_path / "session.mcap")


def test_what_the_processes_are_is_in_each_file(hub: InProcessHub, tmp_path: Path) -> None:
    facts = {"configuration": "{}", "model": "tiny.gguf", "model_sha256": "ab12"}
    health = Health(
        stamp_ns=1, service="llm", instance="1", phase="ready", pid=1, cpu_percent=0.0,
        memory_mb=1.0, facts=facts,
    )  # fmt: skip

    def has_them(path: Path) -> bool:
        recording = Recording(path)
        list(recording.messages(decode=False))
        return recording.metadata.get("process llm/1") == facts

    with patch("w2c_recorder.node.STATUS_PERIOD_S", 0.02), recorder(hub, tmp_path) as operator:
        llm = hub.connect("llm")
        llm.publish(topics.HEALTH, health)
        wait_until(lambda: has_them(tmp_path / "session.mcap"))
        operator.call(topics.RECORD_STOP, Empty())
        operator.call(topics.RECORD_START, RecordRequest())
        wait_until(lambda: has_them(tmp_path / "session-1.mcap"))  # nobody said it again
        operator.call(topics.RECORD_STOP, Empty())

    (one,) = overview_of(Recording(tmp_path / "session.mcap")).processes.items()
    assert one == ("llm/1", facts)
