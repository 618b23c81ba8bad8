"""Recordings with some of their messages changed or left out."""

from collections.abc import Callable
from pathlib import Path

import msgspec

from w2c.bus import RawReceived, decode_envelope, encode_envelope
from w2c.messages import Message
from w2c_recorder.mcap_file import McapFile
from w2c_recorder.reading import Recorded, Recording

Change = Callable[[Recorded], Message | None]
"""Returns the message to be written in the place of a recorded one, None for none"""


def rewritten(recording: Path, path: Path, change: Change) -> Path:
    """Write a recording with changes, and return where."""
    file = McapFile(path, {})
    for recorded in Recording(recording).messages():
        message = change(recorded)
        if message is None:
            continue
        payload = recorded.payload
        if message is not recorded.message:
            payload = rewrapped(payload, message)
        at_ns = recorded.log_time_ns
        file.write(RawReceived(recorded.key, payload, at_ns), at_ns)
    file.close()
    return path


def rewrapped(payload: bytes, message: Message) -> bytes:
    """Return bytes with another message in the same envelope."""
    return encode_envelope(msgspec.structs.replace(decode_envelope(payload), data=message))
