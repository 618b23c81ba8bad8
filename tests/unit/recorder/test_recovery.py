"""A recording that was cut anywhere is readable up to the cut, and can be given its end."""

from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader

from support.recordings import raw_mark, write_recording
from w2c.errors import RecordingError
from w2c_recorder.config import Compression
from w2c_recorder.mcap_file import McapFile
from w2c_recorder.reading import Recording
from w2c_recorder.recovery import is_closed, recover, recover_directory


def unclosed(
    path: Path, count: int = 20, per_chunk: int = 5, compression: Compression = "lz4"
) -> Path:
    """Write what a killed recorder leaves: whole chunks, no end."""
    file = McapFile(path, {"robot": "test"}, compression)
    for sequence in range(count):
        file.write(raw_mark(f"mark {sequence}", sequence), sequence)
        if sequence % per_chunk == per_chunk - 1:
            file.flush()
    file.abandon()
    return path


def sequences(path: Path) -> list[int]:
    return [recorded.sequence for recorded in Recording(path).messages()]


def test_an_unclosed_file_becomes_one_that_every_reader_opens(tmp_path: Path) -> None:
    path = unclosed(tmp_path / "session.mcap")
    before = [recorded.payload for recorded in Recording(path).messages()]

    assert not is_closed(path)
    assert recover(path) == 20
    assert is_closed(path)
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        after = [message.data for _, _, message in reader.iter_messages()]
    assert after == before
    assert summary is not None
    assert summary.statistics is not None
    assert summary.statistics.message_count == 20


def test_metadata_survives_and_says_that_the_file_was_recovered(tmp_path: Path) -> None:
    path = unclosed(tmp_path / "session.mcap")
    recover(path)
    recording = Recording(path)
    list(recording.messages())

    assert recording.metadata["session"]["robot"] == "test"
    assert recording.metadata["recovery"]["messages"] == "20"
    assert recording.damage.complete


def test_nothing_else_is_left_in_the_directory(tmp_path: Path) -> None:
    recover(unclosed(tmp_path / "session.mcap"))

    assert [path.name for path in tmp_path.iterdir()] == ["session.mcap"]


@settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(cut=st.floats(0.0, 1.0))
def test_a_file_cut_anywhere_gives_a_prefix_of_its_messages(tmp_path: Path, cut: float) -> None:
    path = tmp_path / f"cut-{cut}.mcap"
    path.unlink(missing_ok=True)
    content = unclosed(path).read_bytes()
    path.write_bytes(content[: max(8, int(cut * len(content)))])

    found = sequences(path)
    assert found == list(range(len(found)))
    assert recover(path) == len(found)
    assert sequences(path) == found
    path.unlink()


def test_a_damaged_chunk_loses_only_itself(tmp_path: Path) -> None:
    path = unclosed(tmp_path / "session.mcap", compression="none")
    content = bytearray(path.read_bytes())
    content[content.index(b"mark 12")] ^= 0xFF  # in the third of four chunks
    path.write_bytes(content)

    recording = Recording(path)
    found = [recorded.sequence for recorded in recording.messages()]

    assert found == [*range(10), *range(15, 20)]
    assert recording.damage.skipped_chunks == 1


def test_closed_files_are_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "session.mcap"
    write_recording(path, [raw_mark("a")])
    before = path.read_bytes()

    assert recover_directory(tmp_path) == []
    assert path.read_bytes() == before


def test_a_file_that_is_being_written_is_left_alone(tmp_path: Path) -> None:
    file = McapFile(tmp_path / "session.mcap", {})
    file.write(raw_mark("a"), 1)
    file.flush()

    assert recover_directory(tmp_path) == []
    file.close()
    assert sequences(tmp_path / "session.mcap") == [0]


def test_unreadable_files_are_reported_and_kept(tmp_path: Path) -> None:
    (tmp_path / "empty.mcap").write_bytes(b"")
    (tmp_path / "foreign.mcap").write_bytes(b"this is a text, long enough to be looked at")
    unclosed(tmp_path / "session.mcap")

    found = {recovered.path.name: recovered for recovered in recover_directory(tmp_path)}

    assert "is empty" in found["empty.mcap"].problem
    assert "not an MCAP file" in found["foreign.mcap"].problem
    assert (found["session.mcap"].messages, found["session.mcap"].problem) == (20, "")
    assert (tmp_path / "foreign.mcap").read_bytes().startswith(b"this is a text")


def test_recovering_a_file_that_is_gone_says_so(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="no recording at"):
        recover(tmp_path / "gone.mcap")
