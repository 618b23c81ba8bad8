"""Every message of a key, in order. Why like this: docs/decisions/0001-latest-and-queue.md."""

import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Generic, TypeVar

from w2c.bus.interface import RawReceived, Received
from w2c.messages import Message

M = TypeVar("M", bound=Message)
T = TypeVar("T")


class Mailbox(Generic[T]):
    """Between the bus's thread and the service's. Full: the oldest is dropped, and counted."""

    def __init__(self, size: int, on_drop: Callable[[], None]) -> None:
        self._items: deque[T] = deque()
        self._size = size
        self._on_drop = on_drop
        self._changed = threading.Condition()

    def put(self, item: T) -> None:
        """Append; never blocks."""
        with self._changed:
            if len(self._items) >= self._size:
                self._items.popleft()
                self._on_drop()
            self._items.append(item)
            self._changed.notify()

    def receive(self, timeout_s: float) -> T | None:
        """Return the oldest item; None after the time-out."""
        with self._changed:
            if not self._items:
                self._changed.wait_for(lambda: bool(self._items), timeout_s)
            return self._items.popleft() if self._items else None


class DecodingQueue(Generic[M]):
    """The typed view of a mailbox of bytes: what does not decode is counted and skipped."""

    def __init__(
        self, mailbox: Mailbox[RawReceived], decode: Callable[[RawReceived], Received[M] | None]
    ) -> None:
        self._mailbox = mailbox
        self._decode = decode

    def receive(self, timeout_s: float) -> Received[M] | None:
        """Return the next message that decodes; None after the time-out."""
        deadline = time.monotonic() + timeout_s
        while True:
            raw = self._mailbox.receive(max(0.0, deadline - time.monotonic()))
            if raw is None:
                return None
            received = self._decode(raw)
            if received is not None:
                return received
