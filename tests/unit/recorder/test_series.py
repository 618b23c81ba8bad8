"""Files that a recording went on in are read as the one recording that they are."""

from collections.abc import Iterable
from pathlib import Path

import pytest

from support.recordings import MARK_KEY, raw_mark, raw_message
from w2c import topics
from w2c.bus import RawReceived
from w2c.messages import MarkRequest
from w2c_recorder.liveliness import Liveliness, key_of
from w2c_recorder.mcap_file import McapFile
from w2c_recorder.overview import overview_of
from w2c_recorder.reading import Recording
from w2c_recorder.series import SERIES_METADATA, Part, files_of
from w2c_recorder.timeline import timeline_of

SNAPSHOT_KEY = topics.CONTROLLER_SNAPSHOT.key("test")


def write_part(
    path: Path,
    part: Part,
    messages: Iterable[RawReceived],
    *,
    close: bool = True,
) -> Path:
    """Write one file of a series."""
    file = McapFile(path, {"robot": "test", "part_name": path.name})
    file.describe(SERIES_METADATA, part.metadata())
    for message in messages:
        file.write(message, message.received_ns)
    if close:
        file.close()
    else:
        file.flush()
        file.abandon()
    return path


def snapshot_bytes(sequence: int, received_ns: int) -> RawReceived:
    """Return a message on the snapshot's key; what is in it does not matter to the reader."""
    return raw_message(MarkRequest(text="state"), SNAPSHOT_KEY, sequence, received_ns=received_ns)


@pytest.fixture
def series(tmp_path: Path) -> Path:
    """Three files, with ten and more to sort, and another recording beside them."""
    first = write_part(tmp_path / "session.mcap", Part("a", 0),
                       [raw_mark("one", 0, 1_000), snapshot_bytes(7, 2_000)])  # fmt: skip
    write_part(tmp_path / "session-10.mcap", Part("a", 2), [raw_mark("three", 2, 5_000)])
    write_part(tmp_path / "session-2.mcap", Part("a", 1),
               [snapshot_bytes(7, 1_500), raw_mark("two", 1, 3_000)])  # fmt: skip
    write_part(tmp_path / "session-1.mcap", Part("b", 0), [raw_mark("other", 0, 9_000)])
    return first


def texts(path: Path) -> list[str]:
    found = Recording(path).messages(lambda key: key == MARK_KEY)
    return [one.message.text for one in found if isinstance(one.message, MarkRequest)]


def test_the_first_file_stands_for_all_in_their_order(series: Path) -> None:
    assert texts(series) == ["one", "two", "three"]
    assert [path.name for path in files_of(series).values()] == [
        "session.mcap", "session-2.mcap", "session-10.mcap",
    ]  # fmt: skip


def test_a_later_file_and_another_recording_stand_for_themselves(series: Path) -> None:
    assert texts(series.with_name("session-2.mcap")) == ["two"]
    assert texts(series.with_name("session-1.mcap")) == ["other"]


def test_the_snapshot_that_a_file_begins_with_is_not_read_twice(series: Path) -> None:
    keys = [recorded.key for recorded in Recording(series).messages(decode=False)]

    assert keys.count(SNAPSHOT_KEY) == 1
    alone = Recording(series.with_name("session-2.mcap")).messages(decode=False)
    assert [recorded.key for recorded in alone] == [SNAPSHOT_KEY, MARK_KEY]


def test_the_overview_is_of_all_files(series: Path) -> None:
    overview = overview_of(Recording(series))

    assert (overview.files, overview.messages, overview.damage) == (3, 4, "")
    assert overview.size_bytes == sum(
        series.with_name(name).stat().st_size
        for name in ("session.mcap", "session-2.mcap", "session-10.mcap")
    )
    assert overview.duration_s == pytest.approx(4e-6)
    assert overview.session["part_name"] == "session.mcap"
    (marks,) = [channel for channel in overview.channels if channel.key == MARK_KEY]
    assert (marks.count, marks.lost) == (3, 0)


def test_a_file_that_is_gone_is_told(series: Path) -> None:
    series.with_name("session-2.mcap").unlink()
    recording = Recording(series)

    assert [one.sequence for one in recording.messages(decode=False)] == [0, 7, 2]
    assert recording.damage.lines() == ["1 files of this recording are not there"]


def test_of_the_last_file_of_a_killed_recorder_what_is_there_is_read(series: Path) -> None:
    write_part(series.with_name("session-11.mcap"), Part("a", 3), [raw_mark("late", 3, 6_000)],
               close=False)  # fmt: skip
    recording = Recording(series)

    assert [one.log_time_ns for one in recording.messages(decode=False)][-1] == 6_000
    assert not recording.damage.complete
    (line,) = recording.damage.lines()
    assert "not closed" in line


def test_a_foreign_file_beside_a_recording_is_left_alone(series: Path) -> None:
    series.with_name("session-3.mcap").write_bytes(b"notes")
    series.with_name("session-4.mcap").write_bytes(b"")

    assert texts(series) == ["one", "two", "three"]


def test_who_is_there_is_told_once(tmp_path: Path) -> None:
    there = Liveliness(service="llm", instance="0", alive=True)
    gone = Liveliness(service="llm", instance="0", alive=False)

    def note(change: Liveliness, sequence: int, at_ns: int) -> RawReceived:
        return raw_message(change, key_of("test", change), sequence, received_ns=at_ns)

    first = write_part(tmp_path / "session.mcap", Part("a", 0), [note(there, 0, 1_000)])
    write_part(tmp_path / "session-1.mcap", Part("a", 1),
               [note(there, 1, 2_000), note(gone, 2, 3_000), note(there, 3, 4_000)])  # fmt: skip

    story = [entry.text for entry in timeline_of(Recording(first))]

    assert story == ["appeared", "GONE", "appeared"]


@pytest.mark.parametrize("closed", [True, False], ids=["by its index", "without one"])
def test_a_part_of_the_time_is_read_across_files(series: Path, closed: bool) -> None:
    if not closed:
        for path in files_of(series).values():
            path.write_bytes(path.read_bytes()[:-100])
    recording = Recording(series)

    found = list(recording.messages_between(2_000, 5_000))

    assert [(one.key, one.log_time_ns) for one in found] == [
        (SNAPSHOT_KEY, 2_000), (MARK_KEY, 3_000),
    ]  # fmt: skip
    assert recording.start_ns == 1_000
    assert list(recording.messages_between(7_000, 8_000)) == []


def test_a_damaged_chunk_is_left_out_of_a_part(tmp_path: Path) -> None:
    path = tmp_path / "session.mcap"
    file = McapFile(path, {}, compression="none")
    for number, text in enumerate(("first", "second-text", "third")):
        file.write(raw_mark(text, number, 1_000 * (number + 1)), 1_000 * (number + 1))
        file.flush()
    file.close()
    path.write_bytes(path.read_bytes().replace(b"second-text", b"second-TEXT"))
    recording = Recording(path)

    found = [one.log_time_ns for one in recording.messages_between(0, 10_000)]

    assert found == [1_000, 3_000]
    assert recording.damage.skipped_chunks == 1
    elsewhere = Recording(path)
    assert [one.log_time_ns for one in elsewhere.messages_between(2_500, 10_000)] == [3_000]
    assert elsewhere.damage.skipped_chunks == 0  # nobody looked
