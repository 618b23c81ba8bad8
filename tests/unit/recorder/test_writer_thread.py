"""The writer's thread loses nothing that is queued, and ends a recording without ending itself."""

import time
from collections.abc import Iterator
from pathlib import Path
from unittest.mock import patch

import pytest

from support.recordings import raw_mark, raw_message
from support.waiting import wait_until
from w2c import topics
from w2c.bus import RawReceived
from w2c.bus.mailbox import Mailbox
from w2c.errors import RecordingError, RefusedError
from w2c.messages import MarkRequest
from w2c_recorder import writer_thread
from w2c_recorder.mcap_file import McapFile
from w2c_recorder.reading import Recording
from w2c_recorder.writer_thread import Limits, WriterThread

Inbox = Mailbox[RawReceived]


@pytest.fixture
def inbox() -> Inbox:
    return Mailbox(10_000, lambda: None)


@pytest.fixture
def thread(inbox: Inbox) -> Iterator[WriterThread]:
    writer = WriterThread(inbox, new_file, wall_minus_monotonic_ns=lambda: 1_000_000)
    yield writer
    writer.shut_down()


def new_file(path: Path) -> McapFile:
    return McapFile(path, {"robot": "test"})


def texts(path: Path) -> list[str]:
    found = Recording(path).messages()
    return [r.message.text for r in found if isinstance(r.message, MarkRequest)]


def fill(inbox: Inbox, count: int, first: int = 0) -> list[str]:
    for sequence in range(first, first + count):
        inbox.put(raw_mark(str(sequence), sequence))
    return [str(sequence) for sequence in range(first, first + count)]


def test_stop_writes_everything_that_was_queued(
    inbox: Inbox, thread: WriterThread, tmp_path: Path
) -> None:
    path = tmp_path / "a.mcap"
    thread.start(path)
    sent = fill(inbox, 2000)
    progress = thread.stop()

    assert texts(path) == sent
    assert (progress.recording, progress.messages, progress.error) == (False, 2000, "")
    assert progress.bytes == path.stat().st_size


def test_what_a_note_cannot_be_written_for_ends_the_recording_and_not_its_sender(
    thread: WriterThread, tmp_path: Path
) -> None:
    thread.start(tmp_path / "a.mcap")
    with patch.object(McapFile, "describe", side_effect=KeyError("no such thing")):
        thread.describe("processes", {})

    assert not thread.progress.recording
    assert "the recorder failed: KeyError('no such thing')" in thread.progress.error
    assert not thread.start(tmp_path / "b.mcap").error


def test_what_comes_after_a_stop_is_not_waited_for(
    inbox: Inbox, thread: WriterThread, tmp_path: Path
) -> None:
    thread.start(tmp_path / "a.mcap")
    with patch.object(thread, "_work", lambda: time.sleep(0.01)):  # all of it is left to the stop
        sent = fill(inbox, 3)
        inbox.put(raw_mark("late", 3, received_ns=time.monotonic_ns() + 10**12))
        fill(inbox, 3, first=4)
        thread.stop()

    assert texts(tmp_path / "a.mcap") == sent


def test_what_a_stop_leaves_out_is_told(
    inbox: Inbox,
    thread: WriterThread,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    monkeypatch.setattr(writer_thread, "DRAIN_TIMEOUT_S", 0.0)
    thread.start(tmp_path / "a.mcap")
    with patch.object(thread, "_work", lambda: time.sleep(0.01)):
        thread.describe("barrier", {})  # the thread waits for no message any more
        inbox.put(raw_mark("a", received_ns=time.monotonic_ns() - 2 * 10**9))
        thread.stop()

    assert texts(tmp_path / "a.mcap") == []
    (told,) = [one.getMessage() for one in caplog.records if one.levelname == "ERROR"]
    assert told.startswith("the last 2.0 s are not in the recording")


def test_arrival_is_stamped_in_wall_time(
    inbox: Inbox, thread: WriterThread, tmp_path: Path
) -> None:
    thread.start(tmp_path / "a.mcap")
    inbox.put(raw_mark("a", received_ns=7))
    thread.stop()

    (recorded,) = Recording(tmp_path / "a.mcap").messages()
    assert recorded.log_time_ns == 1_000_007


def test_what_comes_between_two_recordings_is_in_neither(
    inbox: Inbox, thread: WriterThread, tmp_path: Path
) -> None:
    thread.start(tmp_path / "a.mcap")
    first = fill(inbox, 3)
    thread.stop()
    fill(inbox, 3, first=3)
    wait_until(lambda: inbox.receive(0.0) is None)
    thread.stop()  # runs after the thread has put the last message aside
    thread.start(tmp_path / "b.mcap")
    second = fill(inbox, 3, first=6)
    thread.stop()

    assert texts(tmp_path / "a.mcap") == first
    assert texts(tmp_path / "b.mcap") == second


def test_a_pause_is_no_loss(inbox: Inbox, thread: WriterThread, tmp_path: Path) -> None:
    thread.start(tmp_path / "a.mcap")
    fill(inbox, 1)
    thread.stop()
    thread.start(tmp_path / "b.mcap")
    fill(inbox, 2, first=100)

    assert thread.stop().lost == {}


def test_shutting_down_closes_the_recording(inbox: Inbox, tmp_path: Path) -> None:
    writer = WriterThread(inbox, new_file)
    writer.start(tmp_path / "a.mcap")
    sent = fill(inbox, 50)
    writer.shut_down()
    recording = Recording(tmp_path / "a.mcap")

    assert [r.sequence for r in recording.messages()] == [int(text) for text in sent]
    assert recording.damage.complete


def test_shutting_down_twice_is_harmless_and_commands_are_refused_after(
    inbox: Inbox, tmp_path: Path
) -> None:
    writer = WriterThread(inbox, new_file)
    writer.shut_down()
    writer.shut_down()

    with pytest.raises(RefusedError, match="shutting down"):
        writer.start(tmp_path / "a.mcap")


def test_a_second_start_is_refused_and_names_the_file(thread: WriterThread, tmp_path: Path) -> None:
    thread.start(tmp_path / "a.mcap")

    with pytest.raises(RefusedError, match=r"already recording into .*a\.mcap"):
        thread.start(tmp_path / "b.mcap")
    assert thread.progress.recording


def test_what_was_received_is_on_the_disk_without_a_stop(
    inbox: Inbox, thread: WriterThread, tmp_path: Path
) -> None:
    """This is what a killed recorder leaves behind."""
    thread.start(tmp_path / "a.mcap")
    fill(inbox, 10)

    wait_until(lambda: thread.progress.messages == 10)
    assert len(texts(tmp_path / "a.mcap")) == 10


def test_a_path_that_cannot_be_written_is_an_error_and_the_thread_goes_on(
    inbox: Inbox, thread: WriterThread, tmp_path: Path
) -> None:
    with pytest.raises(RecordingError, match="cannot be written"):
        thread.start(tmp_path / "missing" / "a.mcap")
    assert "cannot be written" in thread.progress.error
    assert not thread.progress.recording

    thread.start(tmp_path / "b.mcap")
    sent = fill(inbox, 3)
    thread.stop()
    assert texts(tmp_path / "b.mcap") == sent


class FailingFile(McapFile):
    """A recording on a disk that fills up at the third message."""

    def write(self, received: RawReceived, log_time_ns: int) -> None:
        if self.messages == 2:
            raise RecordingError("No space left on device")
        super().write(received, log_time_ns)


def test_a_disk_that_fills_up_ends_the_recording_loudly_and_nothing_else(
    inbox: Inbox, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    def make(path: Path) -> McapFile:
        return FailingFile(path, {}) if path.name == "a.mcap" else new_file(path)

    writer = WriterThread(inbox, make)
    writer.start(tmp_path / "a.mcap")
    fill(inbox, 5)
    wait_until(lambda: writer.progress.error != "")

    assert not writer.progress.recording
    assert "No space left" in writer.progress.error
    assert any(record.levelname == "ERROR" for record in caplog.records)

    writer.start(tmp_path / "b.mcap")
    sent = fill(inbox, 3)
    writer.shut_down()
    assert texts(tmp_path / "b.mcap") == sent


class LateFile(McapFile):
    """A recording on a disk that says at the end, too, that it is full."""

    def write(self, received: RawReceived, log_time_ns: int) -> None:
        self._output.close()
        raise RecordingError("No space left on device")


def test_a_file_that_cannot_even_be_released_is_stopped_and_told(
    inbox: Inbox, tmp_path: Path
) -> None:
    writer = WriterThread(inbox, lambda path: LateFile(path, {}))
    writer.start(tmp_path / "a.mcap")
    fill(inbox, 1)
    wait_until(lambda: writer.progress.error != "")
    writer.shut_down()

    assert (writer.progress.recording, writer.progress.error) == (False, "No space left on device")


class BrokenFile(McapFile):
    """A recording with a defect in the program."""

    def write(self, received: RawReceived, log_time_ns: int) -> None:
        raise ZeroDivisionError("a defect")


def test_a_defect_ends_the_recording_with_its_name(inbox: Inbox, tmp_path: Path) -> None:
    writer = WriterThread(inbox, lambda path: BrokenFile(path, {}))
    writer.start(tmp_path / "a.mcap")
    fill(inbox, 1)
    wait_until(lambda: writer.progress.error != "")
    writer.shut_down()

    assert "ZeroDivisionError" in writer.progress.error


def test_the_reserve_of_the_disk_is_left_to_others_and_the_file_is_closed(
    inbox: Inbox, tmp_path: Path
) -> None:
    free = [10**9]
    writer = WriterThread(
        inbox, new_file, minimum_free_bytes=200_000_000, free_bytes=lambda _directory: free[0]
    )
    writer.start(tmp_path / "a.mcap")
    sent = fill(inbox, 5)
    wait_until(lambda: writer.progress.messages == 5)
    free[0] = 100_000_000
    wait_until(lambda: writer.progress.error != "")

    with pytest.raises(RecordingError, match="has 100 MB left, the recorder leaves 200 MB"):
        writer.start(tmp_path / "b.mcap")
    writer.shut_down()
    assert not (tmp_path / "b.mcap").exists()
    recording = Recording(tmp_path / "a.mcap")
    assert [str(recorded.sequence) for recorded in recording.messages()] == sent
    assert recording.damage.complete


def test_a_full_file_is_followed_by_the_next_and_nothing_is_lost(
    inbox: Inbox, tmp_path: Path
) -> None:
    names = iter(["a-1.mcap", "a-2.mcap", "a-3.mcap"])
    writer = WriterThread(
        inbox,
        new_file,
        successor=lambda first: first.with_name(next(names)),
        limits=Limits(size_bytes=100),
    )
    writer.start(tmp_path / "a.mcap")
    sent = fill(inbox, 50)
    wait_until(lambda: writer.progress.path.endswith("a-1.mcap"))
    sent += fill(inbox, 50, first=50)
    progress = writer.stop()
    writer.shut_down()

    files = sorted(tmp_path.iterdir(), key=lambda path: path.stat().st_ctime_ns)
    assert [path.name for path in files][:2] == ["a.mcap", "a-1.mcap"]
    assert texts(tmp_path / "a.mcap") == sent  # the files that follow are read with the first
    assert (progress.error, progress.lost) == ("", {})
    assert Path(progress.path).name != "a.mcap"


def test_the_next_file_begins_with_the_last_snapshot(inbox: Inbox, tmp_path: Path) -> None:
    key = topics.CONTROLLER_SNAPSHOT.key("test")
    writer = WriterThread(
        inbox,
        new_file,
        successor=lambda first: first.with_name("b.mcap"),
        limits=Limits(duration_s=0.01),
    )
    writer.start(tmp_path / "a.mcap")
    for sequence in range(2):
        inbox.put(raw_message(MarkRequest(text="x"), key, sequence))
    wait_until((tmp_path / "b.mcap").exists)
    inbox.put(raw_mark("later"))
    writer.shut_down()

    begins = next(Recording(tmp_path / "b.mcap").messages())
    assert (begins.key, begins.sequence) == (key, 1)


def test_where_the_next_file_cannot_be_made_the_recording_stops_loudly(
    inbox: Inbox, tmp_path: Path
) -> None:
    writer = WriterThread(
        inbox,
        new_file,
        successor=lambda first: first.parent / "missing" / "b.mcap",
        limits=Limits(duration_s=0.01),
    )
    writer.start(tmp_path / "a.mcap")
    sent = fill(inbox, 3)
    wait_until(lambda: not writer.progress.recording)
    writer.shut_down()

    assert "missing/b.mcap cannot be written" in writer.progress.error
    assert texts(tmp_path / "a.mcap") == sent
