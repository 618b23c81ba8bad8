"""A recording once more, with channels for Foxglove, or with nothing else."""

from dataclasses import dataclass
from pathlib import Path

from w2c.bus import RawReceived
from w2c_recorder.foxglove.mirror import Mirror
from w2c_recorder.mcap_file import SESSION_METADATA, McapFile
from w2c_recorder.metadata import PROCESS_PREFIX
from w2c_recorder.reading import Recording


@dataclass(frozen=True)
class Copied:
    """What is in the new file."""

    messages: int
    """Of the bus"""
    shown: int
    """For Foxglove"""
    problem: str
    """Why the robot does not move, for people; empty where it does"""


def copy_shown(source: Recording, out: Path, *, alone: bool = False) -> Copied:
    """Write the messages of a recording, and what Foxglove shows of them.

    Args:
        source: the recording; channels for Foxglove that it has are made anew.
        out: of the new file.
        alone: the messages of the bus are left out.

    Raises:
        RecordingError: the recording cannot be read, or the file cannot be written.
    """
    mirror = Mirror()
    source.read_metadata()
    session = source.metadata.get(SESSION_METADATA, {})
    file = McapFile(out, session, mirror=mirror, shown_alone=alone)
    for recorded in source.messages(decode=False):
        raw = RawReceived(recorded.key, recorded.payload, recorded.log_time_ns)
        file.write(raw, recorded.log_time_ns)
    for name, facts in source.metadata.items():
        if name.startswith(PROCESS_PREFIX):
            file.describe(name, facts)
    file.close()
    return Copied(file.messages, file.shown, mirror.problem)
