"""A recording as services read it that run on it again. See `w2c.through.Session`."""

import math
from collections.abc import Iterator
from typing import Any

from w2c import topics
from w2c.bus import Input
from w2c.messages import CallTrace, ErrorReply
from w2c.through import Asked, Heard
from w2c_recorder.reading import Recorded, Recording, decode_payload, method_of, topic_of


class RecordedSession:
    """Reads a recording up to a time."""

    def __init__(self, recording: Recording, end_s: float = math.inf) -> None:
        self._recording = recording
        self._end_s = end_s

    def heard(self, *rows: topics.Topic[Any]) -> Iterator[Heard]:
        """Yield the messages of these streams that decode, in the order of their arrival."""
        for recorded, seconds in self._until_end(*rows):
            if recorded.message is not None and recorded.envelope is not None:
                row = recorded.topic
                if row is not None:
                    yield Heard(row, recorded.message, recorded.envelope, recorded.key, seconds)

    def asked(self, *services: str) -> Iterator[Asked]:
        """Yield the calls to these services, in the order in which their traces arrived."""
        for recorded, seconds in self._until_end(topics.TRACE):
            trace = recorded.message
            if isinstance(trace, CallTrace) and trace.service in services:
                yield _asked(recorded, trace, seconds)

    def _until_end(self, *rows: topics.Topic[Any]) -> Iterator[tuple[Recorded, float]]:
        for recorded in self._recording.messages(lambda key: topic_of(key) in rows):
            seconds = (recorded.log_time_ns - self._recording.start_ns) * 1e-9
            if seconds > self._end_s:
                return
            yield recorded, seconds


def _asked(recorded: Recorded, trace: CallTrace, seconds: float) -> Asked:
    method = method_of(trace)
    request_type, reply_type = (None, None) if method is None else (method.request, method.reply)
    envelope, request, _ = decode_payload(trace.request, request_type)
    answer, reply, _ = decode_payload(
        trace.reply, reply_type if trace.outcome == "ok" else ErrorReply
    )
    source = None
    if envelope is not None:
        key = f"w2c/{topics.VERSION}/{envelope.robot}/rpc/{trace.service}"
        key = f"{key}/{trace.instance}/{trace.method}"
        source = Input(key=key, boot_id=envelope.boot_id, sequence=envelope.sequence)
    return Asked(
        service=trace.service,
        method=trace.method,
        outcome=trace.outcome,
        error=trace.error,
        request=request,
        reply=reply,
        caller="" if recorded.envelope is None else recorded.envelope.sender,
        replier_boot_id="" if answer is None else answer.boot_id,
        inputs=() if envelope is None else tuple(envelope.inputs),
        source=source,
        began_s=seconds - trace.duration_ms * 1e-3,
        seconds=seconds,
    )
