"""Recordings as decoded messages, in the order of their arrival; also from unclosed files."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from mcap.records import Message as McapMessage
from mcap.well_known import MessageEncoding

from w2c import topics
from w2c.bus import Envelope, decode_envelope
from w2c.bus.codec import validate
from w2c.errors import ConfigError, MessageError
from w2c.messages import CallTrace, ErrorReply, Message
from w2c_recorder.mcap_file import message_type_of
from w2c_recorder.newer import known_part
from w2c_recorder.records import Damage, RecordReader
from w2c_recorder.schemas import same_schema


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
    """A file to be read. Can be read again and again; each time from its beginning."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.metadata: dict[str, dict[str, str]] = {}
        """Name -> values. Complete after all messages were read, because the last is at the end."""
        self.damage = Damage()
        """What could not be read. Final after all messages were read."""
        self.elsewhere: dict[str, int] = {}
        """Topic -> messages in other encodings: repeats for other programs, or foreign ones."""
        self._reader = RecordReader(path)
        self._read_whole = False
        self.start_ns = 0
        """Arrival of the first message of any key [ns since 1970]; 0 before one was read."""

    def messages(
        self, wanted: Callable[[str], bool] = lambda _key: True, *, decode: bool = True
    ) -> Iterator[Recorded]:
        """Yield the messages whose key is wanted.

        Without `decode` only bytes and times are there, which is what counting needs.

        Raises:
            RecordingError: there is no such file, or it is no recording.
        """
        reader = RecordReader(self.path)
        elsewhere: dict[str, int] = {}
        if not self._read_whole:  # a second look that ends early must not forget what the first saw
            self._reader, self.damage, self.elsewhere = reader, reader.damage, elsewhere
        for record in reader.contents():
            if isinstance(record, McapMessage):
                self.start_ns = self.start_ns or record.log_time
                channel = reader.channels[record.channel_id]
                key = channel.topic
                if channel.message_encoding != MessageEncoding.MessagePack:
                    elsewhere[key] = elsewhere.get(key, 0) + 1
                elif wanted(key):
                    yield _recorded(key, record, decode=decode)
            else:
                self.metadata[record.name] = dict(record.metadata)
        self._reader, self.damage, self.elsewhere = reader, reader.damage, elsewhere
        self._read_whole = True

    def read_metadata(self) -> None:
        """Read what stands before the first message."""
        next(self.messages(decode=False), None)

    def other_schemas(self) -> dict[str, str]:
        """Return key -> message of the channels read so far that another version described."""
        found = {}
        for channel in self._reader.channels.values():
            schema = self._reader.schemas.get(channel.schema_id)
            known = message_type_of(channel.topic)
            if schema is not None and known is not None and not same_schema(schema.data, known):
                found[channel.topic] = schema.name
        return found

    def of(self, *rows: topics.Topic[Any]) -> Iterator[Recorded]:
        """Yield the messages of these rows of the registry, of whichever robot, that decode."""
        for recorded in self.messages(lambda key: topic_of(key) in rows):
            if recorded.message is not None:
                yield recorded


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
    data, unknown = known_part(envelope.data, message_type)
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
