"""Messages and recordings for the tests of the recorder."""

import time
from collections.abc import Iterable, Sequence
from pathlib import Path

from w2c import topics
from w2c.bus import Envelope, Input, RawReceived, encode_envelope
from w2c.bus.codec import ENVELOPE_VERSION
from w2c.messages import MarkRequest, Message
from w2c_recorder.mcap_file import McapFile

MARK_KEY = topics.MARK.key("test")


def raw_message(
    message: Message,
    key: str,
    sequence: int = 0,
    *,
    boot_id: str = "boot",
    sender: str = "recorder",
    received_ns: int | None = None,
    inputs: Sequence[Input] = (),
    clock_ns: int | None = None,
) -> RawReceived:
    """Return a message as the bus delivers it to the recorder."""
    envelope = Envelope(
        version=ENVELOPE_VERSION,
        robot="test",
        sender=sender,
        boot_id=boot_id,
        sequence=sequence,
        monotonic_ns=0,
        clock_ns=1_000 + sequence if clock_ns is None else clock_ns,
        inputs=list(inputs),
        data=message,
    )
    arrival_ns = time.monotonic_ns() if received_ns is None else received_ns
    return RawReceived(key=key, payload=encode_envelope(envelope), received_ns=arrival_ns)


def raw_mark(text: str, sequence: int = 0, received_ns: int | None = None) -> RawReceived:
    """Return a mark of the operator as the bus delivers it."""
    return raw_message(MarkRequest(text=text), MARK_KEY, sequence, received_ns=received_ns)


def write_recording(path: Path, messages: Iterable[RawReceived], *, close: bool = True) -> McapFile:
    """Write a recording; unclosed, it is what a killed recorder leaves behind."""
    file = McapFile(path, {"robot": "test", "w2c": "0"})
    for message in messages:
        file.write(message, message.received_ns)
    if close:
        file.close()
    else:
        file.flush()
        file.abandon()
    return file
