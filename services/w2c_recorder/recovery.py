"""Give recordings whose recorder was killed the end that they lack."""

import fcntl
import os
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from mcap.records import Message
from mcap.writer import CompressionType, Writer

from w2c.errors import RecordingError
from w2c_recorder.mcap_file import CHUNK_BYTES, PROFILE
from w2c_recorder.records import RecordReader

RECOVERY_METADATA = "recovery"
MAGIC = b"\x89MCAP0\r\n"


@dataclass(frozen=True)
class Recovered:
    """One file that was rewritten, or could not be."""

    path: Path
    messages: int
    """Found and kept."""
    problem: str = ""
    """Why the file was left as it was; empty where it was rewritten."""


def is_closed(path: Path) -> bool:
    """Tell whether a file ends as its writer ends it. Raises OSError."""
    with path.open("rb") as stream:
        size = stream.seek(0, os.SEEK_END)
        if size < 2 * len(MAGIC):
            return False
        stream.seek(-len(MAGIC), os.SEEK_END)
        return stream.read() == MAGIC


def recover_directory(directory: Path) -> list[Recovered]:
    """Rewrite every unclosed `*.mcap` file of a directory that nobody is writing."""
    found = []
    for path in sorted(directory.glob("*.mcap")):
        try:
            if is_closed(path) or _is_being_written(path):
                continue
            found.append(Recovered(path, recover(path)))
        except (RecordingError, OSError) as error:
            found.append(Recovered(path, 0, problem=str(error)))
    return found


def recover(path: Path) -> int:
    """Rewrite one file with index and end; the original goes only when the new one is on the disk.

    Returns:
        The number of messages in it.

    Raises:
        RecordingError: nothing in the file can be read, or there is no room for the new one.
    """
    unfinished = path.with_suffix(".mcap.recovering")
    try:
        with unfinished.open("wb") as output:
            writer = Writer(output, chunk_size=CHUNK_BYTES, compression=CompressionType.LZ4)
            messages = _rewrite(RecordReader(path), writer)
            output.flush()
            os.fsync(output.fileno())
        unfinished.replace(path)
    except OSError as error:
        raise RecordingError(
            f"{path} could not be recovered: {error.strerror}; it is as it was"
        ) from error
    finally:
        with suppress(OSError):  # it became the recording, or nothing can be written there
            unfinished.unlink()
    return messages


def _rewrite(reader: RecordReader, writer: Writer) -> int:
    """Copy everything readable. Returns the number of messages."""
    writer.start(profile=PROFILE, library="words2contact recovery")
    schemas: dict[int, int] = {0: 0}
    channels: dict[int, int] = {}
    messages = 0
    for record in reader.contents():
        if not isinstance(record, Message):
            writer.add_metadata(record.name, record.metadata)
            continue
        if record.channel_id not in channels:
            channels[record.channel_id] = _copy_channel(reader, writer, record.channel_id, schemas)
        writer.add_message(
            channels[record.channel_id],
            log_time=record.log_time,
            data=record.data,
            publish_time=record.publish_time,
            sequence=record.sequence,
        )
        messages += 1
    damage = reader.damage
    writer.add_metadata(
        RECOVERY_METADATA,
        {
            "reason": damage.reason,
            "messages": str(messages),
            "skipped_chunks": str(damage.skipped_chunks),
            "orphans": str(damage.orphans),
        },
    )
    writer.finish()  # type: ignore[no-untyped-call]
    return messages


def _copy_channel(
    reader: RecordReader, writer: Writer, channel_id: int, schemas: dict[int, int]
) -> int:
    """Describe a channel in the new file. Returns its number there."""
    channel = reader.channels[channel_id]
    schema = reader.schemas.get(channel.schema_id)
    if channel.schema_id not in schemas:
        schemas[channel.schema_id] = (
            0  # it was described in a damaged chunk
            if schema is None
            else writer.register_schema(
                name=schema.name, encoding=schema.encoding, data=schema.data
            )
        )
    return writer.register_channel(
        topic=channel.topic,
        message_encoding=channel.message_encoding,
        schema_id=schemas[channel.schema_id],
        metadata=channel.metadata,
    )


def _is_being_written(path: Path) -> bool:
    """Tell whether a living recorder holds the file."""
    with path.open("rb") as stream:
        try:
            fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return True
    return False
