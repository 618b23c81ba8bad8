"""Traffic as a robot with a camera makes it, at a chosen rate."""

import os
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from w2c import topics
from w2c.bus import Envelope, RawReceived, encode_envelope
from w2c.bus.codec import ENVELOPE_VERSION

ROBOT = "bench"
STATE_HZ = 500
STATE_BYTES = 1200
COMMAND_BYTES = 600
PICTURES_HZ = 30
EVERY = STATE_HZ // PICTURES_HZ + 1
"""States between two pictures"""


@dataclass(frozen=True)
class _Stream:
    key: str
    head: bytes
    tail: bytes

    def message(self, sequence: int) -> bytes:
        """Return the bytes of the message with a number."""
        return self.head + sequence.to_bytes(8, "big") + self.tail


def _stream(topic: topics.Topic[Any], size_bytes: int) -> _Stream:
    """Return a stream of messages of a size; they hold noise, as compressed pictures do."""
    number = 0x0123_4567_89AB_CDEF  # of eight bytes, as all that take its place
    envelope = Envelope(
        version=ENVELOPE_VERSION, robot=ROBOT, sender=topic.service, boot_id=topic.service,
        sequence=number, monotonic_ns=time.monotonic_ns(), clock_ns=time.time_ns(), inputs=[],
        data={"noise": os.urandom(size_bytes)},
    )  # fmt: skip
    head, tail = encode_envelope(envelope).split(number.to_bytes(8, "big"), maxsplit=1)
    return _Stream(topic.key(ROBOT), head, tail)


class Traffic:
    """States and commands at 500 Hz, and pictures at 30 Hz that fill up to the rate."""

    def __init__(self, bytes_per_s: float) -> None:
        rest = bytes_per_s - STATE_HZ * (STATE_BYTES + COMMAND_BYTES)
        self._state = _stream(topics.ROBOT_STATE, STATE_BYTES)
        self._command = _stream(topics.JOINT_COMMAND, COMMAND_BYTES)
        self._picture = _stream(topics.CAMERA_FRAME, max(1000, round(rest * EVERY / STATE_HZ)))

    def messages(self, seconds: float) -> Iterator[RawReceived]:
        """Yield messages at their times; who is late is not waited for."""
        begin_ns = time.monotonic_ns()
        for tick in range(round(seconds * STATE_HZ)):
            wait_ns = begin_ns + tick * 1_000_000_000 // STATE_HZ - time.monotonic_ns()
            if wait_ns > 0:
                time.sleep(wait_ns * 1e-9)
            for stream in (self._state, self._command):
                yield RawReceived(stream.key, stream.message(tick), time.monotonic_ns())
            if tick % EVERY == 0:
                payload = self._picture.message(tick // EVERY)
                yield RawReceived(self._picture.key, payload, time.monotonic_ns())
