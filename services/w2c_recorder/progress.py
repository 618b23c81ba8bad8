"""What a recording has reached, as others may read it."""

from dataclasses import dataclass, field

from w2c_recorder.mcap_file import McapFile


@dataclass(frozen=True)
class Progress:
    """What the thread does, as of its last flush."""

    path: str = ""
    """Of the current recording, or of the last one"""
    recording: bool = False
    messages: int = 0
    bytes: int = 0
    malformed: int = 0
    lost: dict[str, int] = field(default_factory=dict)
    error: str = ""
    """Why the recording stopped by itself"""


def progress_of(file: McapFile, *, recording: bool, error: str = "") -> Progress:
    """Return what a file holds now."""
    return Progress(
        path=str(file.path),
        recording=recording,
        messages=file.messages,
        bytes=file.bytes_written,
        malformed=file.malformed,
        lost=file.losses.lost(),
        error=error,
    )
