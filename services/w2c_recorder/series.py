"""Files that are one recording: `session.mcap` grew too large and went on in `session-1.mcap`."""

import glob
from dataclasses import dataclass
from pathlib import Path

from mcap.records import Metadata

from w2c.errors import RecordingError
from w2c_recorder.records import RecordReader

SERIES_METADATA = "series"


@dataclass(frozen=True)
class Part:
    """Where a file stands in its recording."""

    series: str
    """The same in all files of one recording, and in no other"""
    number: int
    """0 = the first"""

    def metadata(self) -> dict[str, str]:
        """Return what the file says of it."""
        return {"id": self.series, "part": str(self.number)}


def files_of(path: Path) -> dict[int, Path]:
    """Return number -> file of the recording that a file begins, in order.

    A later file of a series stands for itself alone, and so does one that nothing can be read of:
    who reads it will be told.
    """
    own = _part_or_none(path)
    if own is None or own.number != 0:
        return {0: path}
    found = {0: path}
    for other in path.parent.glob(f"{glob.escape(path.stem)}-*{path.suffix}"):
        part = _part_or_none(other)
        if part is not None and part.series == own.series and part.number not in found:
            found[part.number] = other
    return dict(sorted(found.items()))


def _part_or_none(path: Path) -> Part | None:
    """Return what a file says of its place; None where it says nothing."""
    try:
        for record in RecordReader(path).contents():
            if not isinstance(record, Metadata):
                return None
            if record.name == SERIES_METADATA:
                return Part(record.metadata["id"], int(record.metadata["part"]))
    except (RecordingError, KeyError, ValueError):  # the file is none of this recorder's
        return None
    return None
