"""MCAP records in the order of the file, also from one that was never closed or is damaged."""

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO

from mcap.data_stream import ReadDataStream
from mcap.exceptions import InvalidMagic, McapError
from mcap.records import Channel, Chunk, Footer, McapRecord, Message, Metadata, Schema
from mcap.stream_reader import CRCValidationError, StreamReader, breakup_chunk, read_magic

from w2c.errors import RecordingError

RECORD_LIMIT = 1 << 30
"""Garbage read as a length must not make the reader ask for all memory [B]."""

# What the library and the decompressors raise for bytes that are no record.
_DAMAGE = (McapError, CRCValidationError, ValueError, RuntimeError, struct.error, MemoryError)


@dataclass
class Damage:
    """What of a file could not be read. Filled while it is being read."""

    complete: bool = False
    """The file has its end: it was closed by its writer."""
    reason: str = ""
    """Why reading stopped early; empty for a complete file."""
    skipped_chunks: int = 0
    """Chunks in the middle whose bytes are damaged."""
    orphans: int = 0
    """Messages whose channel was described in a damaged chunk."""


@dataclass
class RecordReader:
    """Reads one file. Iterate over `contents()` once; `damage` is final afterwards."""

    path: Path
    damage: Damage = field(default_factory=Damage)
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)

    def contents(self) -> Iterator[Metadata | Message]:
        """Yield metadata and messages in their order; schemas and channels collect in the fields.

        Raises:
            RecordingError: there is no such file, or it is no MCAP file at all.
        """
        try:
            with self.path.open("rb") as stream:
                yield from self._contents(stream)
        except FileNotFoundError as error:
            raise RecordingError(f"no recording at {self.path}") from error
        except OSError as error:
            raise RecordingError(f"{self.path} cannot be read: {error.strerror}") from error

    def _contents(self, stream: IO[bytes]) -> Iterator[Metadata | Message]:
        self._check_magic(stream)
        reader = StreamReader(
            stream, skip_magic=True, emit_chunks=True, record_size_limit=RECORD_LIMIT
        )
        records = reader.records
        while True:
            try:
                record = next(records, None)
            except _DAMAGE as error:
                self.damage.reason = (
                    f"ends in the middle of a record ({type(error).__name__}: {error})"
                )
                return
            if record is None:
                return
            if isinstance(record, Footer):
                self.damage.complete = True
                return
            yield from self._keep(record)

    def _keep(self, record: McapRecord) -> Iterator[Metadata | Message]:
        if isinstance(record, Chunk):
            for inner in self._unpack(record):
                yield from self._keep(inner)
        elif isinstance(record, Schema):
            self.schemas[record.id] = record
        elif isinstance(record, Channel):
            self.channels[record.id] = record
        elif isinstance(record, Metadata):
            yield record
        elif isinstance(record, Message):
            if record.channel_id in self.channels:
                yield record
            else:
                self.damage.orphans += 1

    def _unpack(self, chunk: Chunk) -> list[McapRecord]:
        """Return the records of a chunk; a damaged one is skipped and counted."""
        try:
            return breakup_chunk(chunk, validate_crc=True)
        except _DAMAGE:
            self.damage.skipped_chunks += 1
            return []

    def _check_magic(self, stream: IO[bytes]) -> None:
        try:
            read_magic(ReadDataStream(stream))
        except InvalidMagic as error:
            raise RecordingError(f"{self.path} is not an MCAP file") from error
        except (McapError, struct.error) as error:
            raise RecordingError(
                f"{self.path} is empty: nothing was recorded before the recorder died"
            ) from error
