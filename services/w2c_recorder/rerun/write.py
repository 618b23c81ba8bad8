"""Write a recording for Rerun: through a file of what Foxglove is shown, which Rerun imports.

Not from the recording itself: its channels for Foxglove may be missing or of an older version, and
Rerun 0.41 waits for ever where a chunk in the middle is damaged, which is skipped here.
"""

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from rerun.chunk import Chunk, LazyChunkStream, McapReader

from w2c.errors import RecordingError
from w2c_recorder.foxglove.copy import copy_shown
from w2c_recorder.reading import Recording
from w2c_recorder.rerun.typed import Typed, archetypes, story
from w2c_recorder.timeline import timeline_of
from w2c_recorder.whole_file import whole_file

APPLICATION = "words2contact"
DECODERS = ("foxglove", "protobuf", "metadata", "recording_info")
"""Not `raw`, which would keep every message a second time"""


@dataclass(frozen=True)
class Written:
    """What is in the file."""

    rows: Counter[str]
    """Archetype -> rows"""
    problem: str
    """Why the robot does not move, for people; empty where it does"""


def write_rrd(source: Recording, out: Path) -> Written:
    """Write a file for Rerun; whatever happens, there is the whole file under its name, or none.

    Args:
        source: the recording.
        out: of the new file.

    Raises:
        RecordingError: there is no such recording, or no room for the file.
        ConfigError: the file is there already, or cannot be made.
    """
    source.read_metadata()
    rows: Counter[str] = Counter()
    with whole_file(out) as unfinished:
        shown = unfinished.with_name("shown.mcap")
        problem = _show(source, shown, out)
        chunks = _Noted(_counted(_chunks(source, shown), rows))
        try:
            LazyChunkStream.from_iter(chunks).write_rrd(
                unfinished,
                application_id=APPLICATION,
                recording_id=f"{source.path.stem}-{source.start_ns}",
            )
        except RuntimeError as error:
            if chunks.raised is not None:
                raise chunks.raised from None
            raise _no_room(out, str(error)) from error
    return Written(rows, problem)


def _show(source: Recording, shown: Path, out: Path) -> str:
    """Write what Foxglove is shown, and return why nothing moves in it."""
    try:
        return copy_shown(source, shown, alone=True).problem
    except RecordingError as error:
        if not isinstance(error.__cause__, OSError):  # it is the recording that cannot be read
            raise
        raise _no_room(out, str(error.__cause__.strerror)) from error


def _chunks(source: Recording, shown: Path) -> Iterator[Chunk]:
    reader = McapReader(shown, decoders=DECODERS)
    yield from Typed().chunks(reader.stream())
    yield from story(timeline_of(source), source.start_ns)


def _counted(chunks: Iterable[Chunk], rows: Counter[str]) -> Iterator[Chunk]:
    for chunk in chunks:
        if not chunk.is_static:  # names of series, and what the session was
            rows.update(dict.fromkeys(archetypes(chunk), chunk.num_rows))
        yield chunk


class _Noted:
    """Remembers what making a chunk raised, Ctrl-C too: Rerun makes a RuntimeError of it."""

    def __init__(self, chunks: Iterable[Chunk]) -> None:
        self._chunks = chunks
        self.raised: BaseException | None = None

    def __iter__(self) -> Iterator[Chunk]:
        try:
            yield from self._chunks
        except BaseException as error:
            self.raised = error
            raise


def _no_room(out: Path, reason: str) -> RecordingError:
    return RecordingError(f"{out} is not written: {reason}; make room, or choose another --out")
