"""Messages of the recorder."""

from typing import Annotated

import msgspec

from w2c.messages.base import Message, Stamp, Text


class RecordRequest(Message, frozen=True, kw_only=True):
    """Start a recording; an empty path = the run directory."""

    path: Text = ""


class MarkRequest(Message, frozen=True, kw_only=True):
    """A remark of the operator, put into the recording."""

    text: Annotated[str, msgspec.Meta(min_length=1, max_length=1000)]


class RecorderStatus(Message, frozen=True, kw_only=True):
    """What is being recorded."""

    stamp_ns: Stamp
    recording: bool
    path: Text
    messages: int
    bytes: int
    lost: dict[str, int]
    """Key -> messages that did not reach the recorder, from gaps in sequence numbers"""
    error: Text = ""
    """Why the recording stopped by itself, e.g. a full disk"""
