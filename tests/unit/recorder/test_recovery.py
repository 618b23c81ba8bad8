"""A recording that was cut anywhere is readable up to the cut, and can be given its end."""

import errno
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader

from support.recordings import raw_mark, write_recording
from w2c.errors import RecordingError
from w2c_recorder.config import Compression
from w2c_recorder.mcap_file import McapFile
from w2c_recorder.overview import overview_of
from w2c_recorder.reading import Recording
from w2c_recorder.records import Damage
from w2c_recorder.recovery import MAGIC, is_closed, recover, recover_directory


def unclosed(
    path: Path,
    count: int = 20,
    per_chunk: int = 5,
    compression: Compression = "lz4",
    *,
    close: bool = False,
) -> Path:
    """Write what a killed recorder leaves: whole chunks, no end; or the same with its end."""
    file = McapFile(path, {"robot": "test"}, compression)
    for sequence in range(count):
        file.write(raw_mark(f"mark {sequence}", sequence), sequence)
        if sequence % per_chunk == per_chunk - 1:
            file.flush()
    file.close() if close else file.abandon()
    return path


@pytest.fixture(scope="module")
def closed(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("closed") / "session.mcap"
    return unclosed(path, compression="zstd", close=True).read_bytes()


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


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
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


@pytest.mark.parametrize("compression", ["lz4", "zstd"])
def test_a_chunk_that_cannot_be_unpacked_loses_only_itself(
    tmp_path: Path, compression: Compression
) -> None:
    path = unclosed(tmp_path / "session.mcap", compression=compression)
    content = bytearray(path.read_bytes())
    last = content.rindex(compression.encode())  # of the last chunk: its bytes and their number
    content[last + len(compression) + 8] ^= 0xFF
    path.write_bytes(content)

    found = sequences(path)

    assert found == [*range(15)]
    assert [one.problem for one in recover_directory(tmp_path)] == [""]
    assert sequences(path) == found


def chunk_starts(path: Path) -> list[int]:
    with path.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    return [one.chunk_start_offset for one in summary.chunk_indexes]


@pytest.mark.parametrize("torn", [9, 60], ids=["no record", "a record of noise"])
@pytest.mark.parametrize("number", [0, 1, 3])
def test_behind_the_torn_head_of_a_chunk_a_closed_file_is_read_on(
    tmp_path: Path, number: int, torn: int
) -> None:
    """The index tells where the next one is, and what the channels are."""
    path = unclosed(tmp_path / "session.mcap", close=True)
    content = bytearray(path.read_bytes())
    start = chunk_starts(path)[number]
    if torn == 9:
        content[start : start + 9] = b"\xff" * 9
    else:
        content[start + 60] ^= 0xFF
    path.write_bytes(content)

    recording = Recording(path)
    found = [recorded.sequence for recorded in recording.messages()]

    assert found == [one for one in range(20) if one // 5 != number]
    assert recording.damage == Damage(complete=True, skipped_chunks=1)


@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(where=st.floats(0.0, 1.0, exclude_max=True), noise=st.binary(min_size=1, max_size=40))
def test_of_a_closed_file_that_is_torn_anywhere_at_most_one_chunk_is_lost(
    closed: bytes, tmp_path: Path, where: float, noise: bytes
) -> None:
    content = bytearray(closed)
    start = len(MAGIC) + int(where * (len(content) - len(MAGIC)))
    content[start : start + len(noise)] = noise[: len(content) - start]
    path = tmp_path / "torn.mcap"
    path.write_bytes(content)

    found = sequences(path)

    assert found == [one for one in range(20) if one in found]
    assert len(found) >= 15
    overview_of(Recording(path))
    assert len(list(Recording(path).messages_between(0, 20))) <= 20


def torn(closed: bytes, path: Path, at: int, noise: bytes) -> Path:
    path.write_bytes(closed[:at] + noise + closed[at + len(noise) :])
    return path


@pytest.mark.parametrize(
    ("at", "noise"), [(10, b"\x04"), (12, b"\x01")], ids=["into the first chunk", "behind the end"]
)
def test_a_torn_length_of_the_first_record_loses_no_message(
    closed: bytes, tmp_path: Path, at: int, noise: bytes
) -> None:
    """From the middle of a chunk, noise reads as records that may reach over the next ones."""
    assert sequences(torn(closed, tmp_path / "torn.mcap", at, noise)) == [*range(20)]


@pytest.mark.parametrize("inside", [1, 9 + 8 + 8 + 8 + 4 + 4 + 4], ids=["record", "data"])
@pytest.mark.parametrize("number", [0, 1])
def test_a_torn_length_of_a_chunk_loses_no_other(
    closed: bytes, tmp_path: Path, number: int, inside: int
) -> None:
    """It reaches to the end of the file then; what unpacks it needs only the first bytes."""
    path = tmp_path / "torn.mcap"
    path.write_bytes(closed)
    torn(closed, path, chunk_starts(path)[number] + inside + 2, b"\x44")

    assert sequences(path) == [*range(20)]


@pytest.mark.parametrize("opcode", [b"\x05", b"\x07"], ids=["message", "index"])
def test_a_chunk_that_became_another_record_loses_only_itself(
    closed: bytes, tmp_path: Path, opcode: bytes
) -> None:
    path = tmp_path / "torn.mcap"
    path.write_bytes(closed)
    torn(closed, path, chunk_starts(path)[0], opcode)
    recording = Recording(path)
    found = [recorded.sequence for recorded in recording.messages()]

    assert found == [*range(5, 20)]
    assert recording.damage == Damage(complete=True, skipped_chunks=1)


def test_what_stands_behind_a_record_of_an_unknown_kind_is_read_once(
    closed: bytes, tmp_path: Path
) -> None:
    path = tmp_path / "torn.mcap"
    path.write_bytes(closed)
    (index,) = (closed.index(b"\x07\x56", one) for one in chunk_starts(path)[1:2])
    torn(closed, path, index, b"\xdf")

    assert sequences(path) == [*range(20)]


def test_an_index_that_names_the_middle_of_a_chunk_loses_no_message(
    closed: bytes, tmp_path: Path
) -> None:
    path = tmp_path / "session.mcap"
    path.write_bytes(closed)
    second = chunk_starts(path)[1]
    content = bytearray(closed)
    at = content.rindex(second.to_bytes(8, "little"))
    content[at : at + 8] = (second + 30).to_bytes(8, "little")
    path.write_bytes(content)

    assert sequences(path) == [*range(20)]


def test_an_index_that_leads_nowhere_leaves_the_other_chunks(tmp_path: Path) -> None:
    path = unclosed(tmp_path / "session.mcap", close=True)
    content = bytearray(path.read_bytes())
    second = chunk_starts(path)[1].to_bytes(8, "little")
    at = content.rindex(second)
    content[at : at + 8] = (2**63 - 1).to_bytes(8, "little")
    path.write_bytes(content)

    found = [recorded.sequence for recorded in Recording(path).messages_between(0, 20)]

    assert found == [*range(5), *range(10, 20)]


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


def test_on_a_disk_that_cannot_be_written_the_file_stays_and_the_reason_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_arguments: object, **_more: object) -> None:
        raise OSError(errno.EROFS, "Read-only file system")

    path = unclosed(tmp_path / "session.mcap")
    with monkeypatch.context() as patched:
        patched.setattr("w2c_recorder.recovery.Writer", refuse)
        patched.setattr(Path, "unlink", refuse)  # which says so even of a file that is not there
        (found,) = recover_directory(tmp_path)

    assert found.problem == (
        f"{path} could not be recovered: Read-only file system; it is as it was"
    )
    assert len(sequences(path)) == 20
