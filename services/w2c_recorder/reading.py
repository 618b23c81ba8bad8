"""Recordings as decoded messages, in the order of their arrival; also from unclosed files."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

from mcap.records import Message as McapMessage
from mcap.well_known import MessageEncoding

from w2c import topics
from w2c.bus import Envelope, decode_envelope
from w2c.bus.codec import validate
from w2c.errors import ConfigError, MessageError
from w2c.messages import CallTrace, ErrorReply, Message
from w2c_recorder.mcap_file import SESSION_METADATA, message_type_of
from w2c_recorder.newer import known_part
from w2c_recorder.records import Damage, RecordReader
from w2c_recorder.schemas import same_schema
from w2c_recorder.series import files_of


@dataclass(frozen=True)
class Recorded:
    """One message of a recording."""

    key: str
    topic: topics.Topic[Any] | None
    """Row of the registry; None for liveliness and for keys that this version does not know"""
    message: Message | None
    """None where the bytes are no such message: see `problem`"""
    envelope: Envelope | None
    """None where the bytes are no envelope"""
    payload: bytes
    """As it was on the wire"""
    log_time_ns: int
    """Arrival at the recorder, its wall clock [ns since 1970]"""
    publish_time_ns: int
    """Sending, the sender's wall clock [ns since 1970]"""
    sequence: int
    problem: str = ""
    """Why the message could not be decoded, or what of it this version does not know"""

    def decoded(self) -> "Recorded":
        """Return a message that was read without `decode`, decoded."""
        envelope, message, problem = decode_payload(self.payload, message_type_of(self.key))
        return replace(self, envelope=envelope, message=message, problem=problem)


class Recording:
    """A file to be read, with those in which it went on. Each look begins at its beginning."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.metadata: dict[str, dict[str, str]] = {}
        """Name -> values. Complete after all messages were read, because the last is at the end."""
        self.start_ns = 0
        """Arrival of the first message of any key [ns since 1970]; 0 before one was read."""
        self._look = _Look()
        self.read_whole = False
        """All messages were read at least once: `damage` is final"""

    @cached_property
    def paths(self) -> dict[int, Path]:
        """Number -> file, in order; 0 is `path`."""
        return files_of(self.path)

    @property
    def damage(self) -> Damage:
        """What could not be read. Final after all messages were read."""
        return self._look.damage()

    @property
    def elsewhere(self) -> dict[str, int]:
        """Topic -> messages in other encodings: repeats for other programs, or foreign ones."""
        return self._look.elsewhere

    @property
    def size_bytes(self) -> int:
        """Of all files [B]."""
        return sum(path.stat().st_size for path in self.paths.values())

    def messages(
        self, wanted: Callable[[str], bool] = lambda _key: True, *, decode: bool = True
    ) -> Iterator[Recorded]:
        """Yield the messages whose key is wanted.

        Without `decode` only bytes and times are there, which is what counting needs.

        Raises:
            RecordingError: there is no such file, or it is no recording.
        """
        look = self._begin_look()
        for path in self.paths.values():
            reader = look.begin(path)
            for record in reader.contents():
                if isinstance(record, McapMessage):
                    self.start_ns = self.start_ns or record.log_time
                    key = look.key_of(record)
                    if key and wanted(key):
                        yield _recorded(key, record, decode=decode)
                elif record.name != SESSION_METADATA or SESSION_METADATA not in self.metadata:
                    self.metadata[record.name] = dict(record.metadata)
        self._look = look
        self.read_whole = True

    def messages_between(
        self, start_ns: int, end_ns: int, wanted: Callable[[str], bool] = lambda _key: True
    ) -> Iterator[Recorded]:
        """Yield the messages, not decoded, that arrived from a time to before another.

        Files that were closed are not read whole: their index tells where to look.

        Args:
            start_ns: First arrival [ns since 1970].
            end_ns: Arrivals from here on are left out.
            wanted: Tells the keys.

        Raises:
            RecordingError: as for `messages`.
        """
        self.read_metadata()
        look = self._begin_look()
        for path in self.paths.values():
            reader = look.begin(path)
            for record in reader.messages_between(start_ns, end_ns):
                key = look.key_of(record)
                if key and wanted(key):
                    yield _recorded(key, record, decode=False)

    def newest_before(self, time_ns: int, wanted: Callable[[str], bool]) -> list[Recorded]:
        """Return the newest message, not decoded, of each wanted key from before a time.

        By the index, as `messages_between`; in the order of arrival.

        Args:
            time_ns: What arrived then or later does not count [ns since 1970].
            wanted: Tells the keys.

        Raises:
            RecordingError: as for `messages`.
        """
        found: dict[str, Recorded] = {}
        for path in reversed(self.paths.values()):
            reader = RecordReader(path)
            for record in reader.newest_before(
                time_ns, lambda key: key not in found and wanted(key)
            ):
                channel = reader.channels[record.channel_id]
                if channel.message_encoding == MessageEncoding.MessagePack:
                    found[channel.topic] = _recorded(channel.topic, record, decode=False)
        return sorted(found.values(), key=lambda one: one.log_time_ns)

    def _begin_look(self) -> "_Look":
        look = _Look(max(self.paths) + 1 - len(self.paths))
        if not self.read_whole:  # a second look that ends early must not forget what the first saw
            self._look = look
        return look

    def why_empty(self) -> str:
        """Return, after all was read, why there was no message of the bus."""
        if self.elsewhere:
            return f"another program wrote it; it has {', '.join(sorted(self.elsewhere)[:5])}"
        return self.damage.reason or "it was closed without one"

    def read_metadata(self) -> None:
        """Read what stands before the first message, and when that one arrived."""
        if not self.start_ns:
            next(self.messages(decode=False), None)

    def other_schemas(self) -> dict[str, str]:
        """Return key -> message of the channels read so far that another version described."""
        found = {}
        for reader in self._look.readers:
            for channel in reader.channels.values():
                schema = reader.schemas.get(channel.schema_id)
                known = message_type_of(channel.topic)
                if schema is not None and known is not None and not same_schema(schema.data, known):
                    found[channel.topic] = schema.name
        return found

    def of(self, *rows: topics.Topic[Any]) -> Iterator[Recorded]:
        """Yield the messages of these rows of the registry, of whichever robot, that decode."""
        for recorded in self.messages(lambda key: topic_of(key) in rows):
            if recorded.message is not None:
                yield recorded


class _Look:
    """What one pass over the files of a recording finds."""

    def __init__(self, missing_files: int = 0) -> None:
        self.readers: list[RecordReader] = []
        self.elsewhere: dict[str, int] = {}
        self._missing_files = missing_files
        self._last_ns = 0
        self._ended_ns = 0
        """Last arrival in the files before the present one [ns since 1970]"""

    def begin(self, path: Path) -> RecordReader:
        """Return the reader of the next file."""
        self._ended_ns = self._last_ns
        self.readers.append(RecordReader(path))
        return self.readers[-1]

    def key_of(self, record: McapMessage) -> str:
        """Return the key of a message; "" for what is no message of the bus, or came before."""
        channel = self.readers[-1].channels[record.channel_id]
        key = channel.topic
        self._last_ns = max(self._last_ns, record.log_time)
        if channel.message_encoding != MessageEncoding.MessagePack:
            self.elsewhere[key] = self.elsewhere.get(key, 0) + 1
            return ""
        # So that each file can be used alone, it begins with the last snapshot before it.
        if record.log_time < self._ended_ns and topic_of(key) is topics.CONTROLLER_SNAPSHOT:
            return ""
        return key

    def damage(self) -> Damage:
        """Return what none of the files gave."""
        found = [(reader.path, reader.damage) for reader in self.readers]
        several = len(found) > 1
        return Damage(
            complete=bool(found) and all(damage.complete for _, damage in found),
            reason="; ".join(
                f"{path.name} {damage.reason}" if several else damage.reason
                for path, damage in found
                if damage.reason
            ),
            skipped_chunks=sum(damage.skipped_chunks for _, damage in found),
            orphans=sum(damage.orphans for _, damage in found),
            missing_files=self._missing_files,
        )


@lru_cache(maxsize=4096)
def topic_of(key: str) -> topics.Topic[Any] | None:
    """Return the registry's row of a key; None for keys that it does not know."""
    try:
        return topics.parse_key(key)[1]
    except ConfigError:
        return None


def decode_call(trace: CallTrace) -> tuple[Message | None, Message | None]:
    """Return the request and the reply inside a trace; None where none is, or none decodes.

    A reply that is an error comes out as the ErrorReply.
    """
    method = method_of(trace)
    if method is None:
        return None, None
    reply_type = method.reply if trace.outcome == "ok" else ErrorReply
    return (
        decode_payload(trace.request, method.request)[1],
        decode_payload(trace.reply, reply_type)[1],
    )


def method_of(trace: CallTrace) -> topics.Method[Any, Any] | None:
    """Return the registry's row of a call; None for one that it does not know."""
    for method in topics.METHODS:
        if (method.service, method.name) == (trace.service, trace.method):
            return method
    return None


def decode_payload(
    payload: bytes, message_type: type[Message] | None
) -> tuple[Envelope | None, Message | None, str]:
    """Return envelope, message, and why one of them is missing.

    Of a message that a newer version wrote, what this version knows is returned; the last string
    then names the fields that were left out.
    """
    if not payload:
        return None, None, "no bytes"
    try:
        envelope = decode_envelope(payload)
    except MessageError as error:
        return None, None, str(error)
    if message_type is None:
        return envelope, None, "this version knows no such key"
    try:
        return envelope, validate(envelope.data, message_type), ""
    except MessageError as error:
        return _partly(envelope, message_type, str(error))


def _partly(
    envelope: Envelope, message_type: type[Message], problem: str
) -> tuple[Envelope, Message | None, str]:
    """Return what this version knows of a message, where a newer one wrote it."""
    try:
        data, unknown = known_part(envelope.data, message_type)
    except RecursionError:  # lists in lists in lists: no version writes that
        return envelope, None, problem
    if not unknown or not data:  # nothing of it is known: another message altogether
        return envelope, None, problem
    try:
        message = validate(data, message_type)
    except MessageError as error:
        return envelope, None, str(error)
    return envelope, message, f"fields of a newer version left out: {', '.join(unknown)}"


def _recorded(key: str, record: McapMessage, *, decode: bool) -> Recorded:
    recorded = Recorded(
        key=key,
        topic=topic_of(key),
        message=None,
        envelope=None,
        payload=record.data,
        log_time_ns=record.log_time,
        publish_time_ns=record.publish_time,
        sequence=record.sequence,
    )
    return recorded.decoded() if decode else recorded
