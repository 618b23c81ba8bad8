"""MCAP records in the order of the file, also from one that was never closed or is damaged."""

import os
import struct
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import InvalidMagic, McapError
from mcap.reader import SeekingReader
from mcap.records import Channel, Chunk, ChunkIndex, Footer, McapRecord, Message, Metadata, Schema
from mcap.stream_reader import CRCValidationError, StreamReader, breakup_chunk, read_magic
from mcap.summary import Summary

from w2c.errors import RecordingError
from w2c_recorder.landmarks import Landmarks

RECORD_LIMIT = 1 << 30
"""Garbage read as a length must not make the reader ask for all memory [B]."""
DISORDER_NS = 10_000_000_000
"""A message may stand this much behind later ones: a file that goes on from another begins with the
last snapshot [ns]"""

# What the library and the decompressors raise for bytes that are no record.
_DAMAGE = (
    *(McapError, CRCValidationError, ValueError, RuntimeError, struct.error, MemoryError),
    *(zstandard.ZstdError, OverflowError),
)


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
    missing_files: int = 0
    """Files of a rotated series that are not there."""

    def lines(self) -> list[str]:
        """Return what people are told of it; nothing for a recording that is whole."""
        found = []
        if not self.complete:
            found.append(f"the recording was not closed: {self.reason or 'it has no end'}")
        for count, what in (
            (self.skipped_chunks, "damaged chunks are missing from this"),
            (self.orphans, "messages are of channels whose description is lost"),
            (self.missing_files, "files of this recording are not there"),
        ):
            if count:
                found.append(f"{count} {what}")
        return found


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
        with self._opened() as stream:
            yield from self._contents(stream)

    def messages_between(self, start_ns: int, end_ns: int) -> Iterator[Message]:
        """Yield the messages that arrived from `start_ns` to before `end_ns` [ns since 1970].

        By the file's index, where it was closed; otherwise by reading what comes before, too.

        Raises:
            RecordingError: as for `contents`.
        """
        with self._opened() as stream:
            summary = self._summary(stream)
            if summary is None:
                found = self._until(stream, end_ns + DISORDER_NS)
            else:
                found = self._indexed(stream, summary, start_ns, end_ns)
            for message in found:
                if start_ns <= message.log_time < end_ns:
                    yield message

    def newest_before(self, time_ns: int, wanted: Callable[[str], bool]) -> list[Message]:
        """Return the newest message of each wanted channel that arrived before a time [ns].

        Raises:
            RecordingError: as for `contents`.
        """
        found: dict[int, Message] = {}
        with self._opened() as stream:
            summary = self._summary(stream)
            if summary is None:
                messages = self._until(stream, time_ns + DISORDER_NS)
            else:
                messages = self._backwards(stream, summary, time_ns, wanted, found)
            for message in messages:
                if message.log_time < time_ns and wanted(self.channels[message.channel_id].topic):
                    known = found.get(message.channel_id)
                    if known is None or known.log_time <= message.log_time:
                        found[message.channel_id] = message
        return list(found.values())

    def _backwards(
        self,
        stream: IO[bytes],
        summary: Summary,
        time_ns: int,
        wanted: Callable[[str], bool],
        found: dict[int, Message],
    ) -> Iterator[Message]:
        """Yield the messages of the chunks, the last first, that hold what is wanted and not found.

        A chunk ends before the next one begins, but for the snapshot that a file may begin with.
        """
        channels = {one.id for one in summary.channels.values() if wanted(one.topic)}
        before = [one for one in summary.chunk_indexes if one.message_start_time < time_ns]
        self.channels.update(summary.channels)
        for index in sorted(before, key=lambda one: one.chunk_start_offset, reverse=True):
            if channels.intersection(index.message_index_offsets) - found.keys():
                yield from self._chunk(stream, index)

    @contextmanager
    def _opened(self) -> Iterator[IO[bytes]]:
        try:
            with self.path.open("rb") as stream:
                yield stream
        except FileNotFoundError as error:
            raise RecordingError(f"no recording at {self.path}") from error
        except OSError as error:
            raise RecordingError(f"{self.path} cannot be read: {error.strerror}") from error

    def _summary(self, stream: IO[bytes]) -> Summary | None:
        """Return the index at the end of a file; None where there is none that can be read."""
        self._check_magic(stream)
        try:
            stream.seek(0)
            summary = SeekingReader(stream, record_size_limit=RECORD_LIMIT).get_summary()
        except (*_DAMAGE, OSError):  # a seek to before the beginning is an OSError
            summary = None
        stream.seek(0)
        return summary if summary is not None and summary.chunk_indexes else None

    def _indexed(
        self, stream: IO[bytes], summary: Summary, start_ns: int, end_ns: int
    ) -> Iterator[Message]:
        self.schemas.update(summary.schemas)
        self.channels.update(summary.channels)
        self.damage.complete = True
        for index in sorted(summary.chunk_indexes, key=lambda one: one.chunk_start_offset):
            if index.message_end_time >= start_ns and index.message_start_time < end_ns:
                yield from self._chunk(stream, index)

    def _chunk(self, stream: IO[bytes], index: ChunkIndex) -> Iterator[Message]:
        try:
            stream.seek(index.chunk_start_offset)
            chunk = next(self._records(stream), None)
        except (*_DAMAGE, OSError):  # a torn index may name a place that no file has
            chunk = None
        if isinstance(chunk, Chunk):
            yield from (one for one in self._keep(chunk) if isinstance(one, Message))
        else:
            self.damage.skipped_chunks += 1

    def _until(self, stream: IO[bytes], last_ns: int) -> Iterator[Message]:
        """Yield the messages from the beginning to the first that arrived after `last_ns`."""
        for record in self._contents(stream):
            if isinstance(record, Message):
                if record.log_time > last_ns:
                    return
                yield record

    @staticmethod
    def _records(stream: IO[bytes]) -> Iterator[McapRecord]:
        return StreamReader(
            stream, skip_magic=True, emit_chunks=True, record_size_limit=RECORD_LIMIT
        ).records

    def _contents(self, stream: IO[bytes]) -> Iterator[Metadata | Message]:
        summary = self._summary(stream)
        landmarks = Landmarks(summary)
        self._check_magic(stream)
        records = self._records(stream)
        while True:
            position = stream.tell()
            try:
                record = next(records, None)
                first = landmarks.first_byte(record, position, stream.tell())
                landmarks.check(record, first, stream.tell())
            except _DAMAGE as error:
                target = self._behind(stream, position, landmarks)
                if target is None:
                    self.damage.reason = (
                        f"ends in the middle of a record ({type(error).__name__}: {error})"
                    )
                    return
                self._describe(summary)
                stream.seek(target)
                records = self._records(stream)
                continue
            if record is None:
                return
            if isinstance(record, Footer):
                self.damage.complete = True
                return
            skipped = self.damage.skipped_chunks
            self.damage.skipped_chunks += landmarks.chunks_between(position, first)
            yield from self._keep(record)
            if self.damage.skipped_chunks > skipped:
                self._describe(summary)
            following = landmarks.next_after(first)
            if following is not None and stream.tell() > following:
                stream.seek(following)
                records = self._records(stream)

    def _behind(self, stream: IO[bytes], position: int, landmarks: Landmarks) -> int | None:
        """Return the next place after what is no record, and count what is lost before it."""
        target = landmarks.next_after(position)
        if target is None or target >= stream.seek(0, os.SEEK_END):
            return None
        self.damage.skipped_chunks += landmarks.chunks_between(position, target)
        return target

    def _describe(self, summary: Summary | None) -> None:
        """Take from the index the channels that a damaged chunk described."""
        if summary is not None:
            self.schemas = {**summary.schemas, **self.schemas}
            self.channels = {**summary.channels, **self.channels}

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
