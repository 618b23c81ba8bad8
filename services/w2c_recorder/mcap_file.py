"""One MCAP file that is being written: channels, chunks, metadata, losses, and its end."""

import fcntl
import logging
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
from mcap.well_known import MessageEncoding, SchemaEncoding
from mcap.writer import CompressionType, IndexType, Writer

from w2c import topics
from w2c.bus import RawReceived
from w2c.errors import ConfigError, RecordingError
from w2c.messages import Message
from w2c_recorder.config import Compression
from w2c_recorder.liveliness import Liveliness, is_liveliness_key
from w2c_recorder.losses import LossCounter
from w2c_recorder.metadata import CLOCKS_METADATA
from w2c_recorder.schemas import json_schema

if TYPE_CHECKING:
    from google.protobuf.message import Message as ProtobufMessage

    from w2c_recorder.foxglove.mirror import Mirror

PROFILE = "words2contact"
SESSION_METADATA = "session"
LOSSES_METADATA = "losses"
FOREVER_NS = 2**63
MIRROR_PREFIX = "foxglove/"
"""Of the topics that repeat what other channels hold, for other programs"""
MOST_CHANNELS = 60_000
"""Of the bus; an MCAP file numbers its channels with 16 bits, and those for Foxglove need some"""
CHUNK_BYTES = 1_000_000
"""Of messages before compression; a chunk is what a crash of the process can lose."""

log = logging.getLogger("w2c.recorder")

_COMPRESSION = {
    "lz4": CompressionType.LZ4,
    "zstd": CompressionType.ZSTD,
    "none": CompressionType.NONE,
}


class EnvelopeHead(msgspec.Struct, frozen=True):
    """The part of an envelope the recorder needs; decoding it skips the message, which is large."""

    boot_id: str
    sequence: int
    clock_ns: int
    sender: str = ""


_DECODE_HEAD = msgspec.msgpack.Decoder(EnvelopeHead).decode
NO_ENVELOPE = (msgspec.DecodeError, UnicodeDecodeError, RecursionError)
"""What decoding raises for bytes that are none; the last for lists in lists in lists ..."""


def head_of(payload: bytes) -> EnvelopeHead | None:
    """Return what an envelope says of its message; None for bytes that are no envelope."""
    try:
        return _DECODE_HEAD(payload)
    except NO_ENVELOPE:
        return None


def message_type_of(key: str) -> type[Message] | None:
    """Return what the registry says a key carries; None for keys that it does not know."""
    if is_liveliness_key(key):
        return Liveliness
    try:
        return topics.parse_key(key)[1].message
    except ConfigError:
        return None


class _Output:
    """The file under the MCAP writer: unbuffered, so that a dead process loses nothing written."""

    def __init__(self, path: Path) -> None:
        self._descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o644)
        # A recorder that starts beside a running one must not "recover" the file from under it.
        fcntl.flock(self._descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        self.written = 0

    def write(self, data: bytes) -> int:
        """Write all of it, or raise OSError."""
        view = memoryview(data)
        while view:
            count = os.write(self._descriptor, view)
            self.written += count
            view = view[count:]
        return len(data)

    def tell(self) -> int:
        """Return the number of bytes written."""
        return self.written

    def flush(self) -> None:
        """Nothing is held back."""

    def sync(self) -> None:
        """Wait until the disk has it."""
        os.fsync(self._descriptor)

    def close(self) -> None:
        """Release the file."""
        os.close(self._descriptor)


class McapFile:
    """A new recording, used by one thread.

    Every method may raise RecordingError, after which only `abandon` is left.
    """

    def __init__(
        self,
        path: Path,
        metadata: dict[str, str],
        compression: Compression = "lz4",
        mirror: "Mirror | None" = None,
        *,
        shown_alone: bool = False,
    ) -> None:
        """Make the file.

        Args:
            path: of the new file.
            metadata: of the session.
            compression: of its chunks.
            mirror: what repeats messages for Foxglove and Rerun; None = nothing is repeated.
            shown_alone: what the mirror makes of the messages is written, and they are not.
        """
        self.path = path
        self.messages = 0
        self.shown = 0
        """Messages for Foxglove and Rerun, beside those of the bus."""
        self.malformed = 0
        """Messages without a readable envelope; recorded all the same."""
        self.left_out = 0
        """Messages of keys that came when the format had no number left for another one."""
        self.losses = LossCounter()
        self._mirror = mirror
        self._shown_alone = shown_alone
        self._clocks: dict[str, int] = {}
        """Sender -> least time that a message was on its way, by both clocks [ns]"""
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        try:
            self._output = _Output(path)
        except OSError as error:
            raise RecordingError(
                f"{path} cannot be written: {error.strerror}; choose another path"
            ) from error
        self._writer = Writer(
            self._output,  # type: ignore[arg-type] # three methods of IO are all it calls
            chunk_size=CHUNK_BYTES,
            compression=_COMPRESSION[compression],
            index_types=IndexType.ALL,
        )
        try:
            with self._writing():
                self._writer.start(
                    profile=PROFILE, library=f"words2contact {metadata.get('w2c', '')}"
                )
                self._writer.add_metadata(SESSION_METADATA, metadata)
        except RecordingError:
            self.abandon()
            path.unlink(missing_ok=True)  # it is ours, and nothing is in it
            raise

    @property
    def bytes_written(self) -> int:
        """Size of the file so far [B]."""
        return self._output.written

    def write(self, received: RawReceived, log_time_ns: int) -> None:
        """Append one message as it was on the wire, with its time of arrival [ns since 1970]."""
        head = head_of(received.payload)
        publish_time_ns = log_time_ns if head is None else head.clock_ns
        sequence = 0 if head is None else head.sequence
        if head is None:
            self.malformed += 1
        else:
            self.losses.observe(received.key, head.boot_id, head.sequence)
            age_ns = log_time_ns - head.clock_ns
            if age_ns < self._clocks.get(head.sender, FOREVER_NS):
                self._clocks[head.sender] = age_ns
        if not self._shown_alone:
            with self._writing():
                channel = self._channel_of(received.key)
                if channel is None:
                    self._leave_out(received.key)
                    return
                self._writer.add_message(
                    channel,
                    log_time=log_time_ns,
                    data=received.payload,
                    # Bounded to what MCAP has room for, because a sender may send nonsense.
                    publish_time=min(max(publish_time_ns, 0), 2**64 - 1),
                    sequence=sequence & 0xFFFF_FFFF,
                )
            self.messages += 1
        if self._mirror is not None:
            self._repeat(self._mirror, received, log_time_ns, publish_time_ns)

    def _repeat(
        self, mirror: "Mirror", received: RawReceived, log_time_ns: int, publish_time_ns: int
    ) -> None:
        """Write a message once more for Foxglove. What was on the bus is safe whatever happens."""
        robot = received.key.split("/")[2] if received.key.count("/") > 1 else ""
        try:
            shown = list(mirror.shown(received.key, received.payload, publish_time_ns))
        except Exception:  # the boundary: the recording goes on without its pictures
            log.exception("nothing is repeated for Foxglove any more")
            self._mirror = None
            return
        with self._writing():
            for one in shown:
                self._writer.add_message(
                    self._shown_channel(f"{MIRROR_PREFIX}{robot}/{one.topic}", one.message),
                    log_time=log_time_ns,
                    data=one.message.SerializeToString(),
                    publish_time=min(max(publish_time_ns, 0), 2**64 - 1),
                )
                self.shown += 1

    def describe(self, name: str, values: dict[str, str]) -> None:
        """Write what is known of the system, beside the messages."""
        with self._writing():
            self._writer.add_metadata(name, values)

    def flush(self) -> None:
        """End the chunk, so that what came so far is readable whatever happens to this process."""
        with self._writing():
            self._writer.flush()  # type: ignore[no-untyped-call]

    def close(self) -> None:
        """Write losses, index and summary, and release the file."""
        losses = {key: str(count) for key, count in self.losses.lost().items()}
        clocks = {sender: str(age_ns) for sender, age_ns in sorted(self._clocks.items())}
        with self._writing():
            self._writer.flush()  # type: ignore[no-untyped-call]
            self._writer.add_metadata(LOSSES_METADATA, losses)
            self._writer.add_metadata(CLOCKS_METADATA, clocks)
            self._writer.finish()  # type: ignore[no-untyped-call]
            self._output.sync()
            self._output.close()

    def abandon(self) -> None:
        """Release the file without an end. What was flushed is readable."""
        with suppress(OSError):  # a disk may say only now that it is full: that is known already
            self._output.close()

    def _leave_out(self, key: str) -> None:
        self.left_out += 1
        if self.left_out == 1:
            log.error(
                "%s and other new keys are not recorded: the file has %d already, which is all "
                "that its format can number; something on the bus invents keys",
                key,
                MOST_CHANNELS,
            )

    def _channel_of(self, key: str) -> int | None:
        """Return the channel of a key; a new key opens one, while there are numbers left."""
        channel = self._channels.get(key)
        if channel is None and len(self._channels) < MOST_CHANNELS:
            message_type = message_type_of(key)
            channel = self._writer.register_channel(
                topic=key,
                message_encoding=MessageEncoding.MessagePack,
                schema_id=0 if message_type is None else self._schema_of(message_type),
            )
            self._channels[key] = channel
        return channel

    def _shown_channel(self, topic: str, message: "ProtobufMessage") -> int:
        channel = self._channels.get(topic)
        if channel is None:
            from w2c_recorder.foxglove.protocol import schema_of

            name, descriptors = schema_of(message)
            if name not in self._schemas:
                self._schemas[name] = self._writer.register_schema(
                    name=name, encoding=SchemaEncoding.Protobuf, data=descriptors
                )
            channel = self._writer.register_channel(
                topic=topic,
                message_encoding=MessageEncoding.Protobuf,
                schema_id=self._schemas[name],
            )
            self._channels[topic] = channel
        return channel

    def _schema_of(self, message_type: type[Message]) -> int:
        name = message_type.__name__
        if name not in self._schemas:
            self._schemas[name] = self._writer.register_schema(
                name=name, encoding=SchemaEncoding.JSONSchema, data=json_schema(message_type)
            )
        return self._schemas[name]

    @contextmanager
    def _writing(self) -> Iterator[None]:
        """Turn what the system says into an error for the operator."""
        try:
            yield
        except OSError as error:
            raise RecordingError(
                f"{self.path} cannot be written any further after {self.bytes_written} bytes: "
                f"{error.strerror}; what came before can be read"
            ) from error
