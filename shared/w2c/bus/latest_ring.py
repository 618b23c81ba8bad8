"""The newest value of a topic on Zenoh. Why polling: docs/decisions/0001-latest-and-queue.md."""

import time
from collections.abc import Callable
from typing import Any, Generic, TypeVar

from w2c.bus.interface import RawReceived, Received
from w2c.messages import Message

M = TypeVar("M", bound=Message)

POLL_S = 0.002


class LatestRing(Generic[M]):
    """The newest message of a topic, out of a ring of one: a slow reader delays nobody."""

    def __init__(
        self, subscriber: Any, decode: Callable[[RawReceived], Received[M] | None]
    ) -> None:
        self._subscriber = subscriber
        self._decode = decode
        self._last: Received[M] | None = None

    def take(self) -> Received[M] | None:
        """Return the newest message that was not taken yet, or None. Never blocks."""
        sample = self._subscriber.try_recv()
        if sample is None:
            return None
        raw = RawReceived(str(sample.key_expr), sample.payload.to_bytes(), time.monotonic_ns())
        received = self._decode(raw)
        if received is not None:
            self._last = received
        return received

    def wait(self, timeout_s: float) -> Received[M] | None:
        """Return the next message that was not taken yet; None after the time-out."""
        deadline = time.monotonic() + timeout_s
        while True:
            received = self.take()
            if received is not None:
                return received
            remaining = deadline - time.monotonic()
            if remaining <= 0:
                return None
            time.sleep(min(POLL_S, remaining))

    def last(self) -> Received[M] | None:
        """Return the newest message ever received, taken or not."""
        self.take()
        return self._last

    def age_s(self) -> float:
        """Return the time since the newest message was taken [s]."""
        last = self.last()
        return float("inf") if last is None else (time.monotonic_ns() - last.received_ns) * 1e-9
