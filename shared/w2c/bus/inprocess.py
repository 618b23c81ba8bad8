"""The bus within one process: tests, and studies that run robot and controller without a network.

Messages are encoded, bounded and validated exactly as on the wire.
"""

import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from concurrent.futures import TimeoutError as FutureTimeoutError
from fnmatch import fnmatchcase
from typing import Any, Generic, TypeVar

from w2c.bus.base import BusBase
from w2c.bus.interface import RawReceived, Received
from w2c.errors import DeadlineError
from w2c.messages import Message
from w2c.topics import Method, Priority, Topic

M = TypeVar("M", bound=Message)


class InProcessHub:
    """What a router is to processes: connects the buses of one process with each other."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.subscriptions: list[tuple[object, str, Callable[[RawReceived], None]]] = []
        self.served: dict[
            str, tuple[object, Callable[[RawReceived], tuple[bool, bytes]], ThreadPoolExecutor]
        ] = {}
        self.tokens: list[tuple[object, str, str, str]] = []

    def connect(self, service: str, *, robot: str = "test", instance: str = "0") -> "InProcessBus":
        """Return the bus of one service."""
        bus = InProcessBus(self, robot, service, instance)
        bus.appear(service, instance)
        return bus

    def deliver(self, raw: RawReceived) -> None:
        """Hand bytes to every subscription that matches, in the sender's thread."""
        with self.lock:
            receivers = [
                put for _, pattern, put in self.subscriptions if _matches(pattern, raw.key)
            ]
        for put in receivers:
            put(raw)

    def remove(self, bus: object) -> None:
        """Forget everything a bus declared."""
        with self.lock:
            self.subscriptions = [row for row in self.subscriptions if row[0] is not bus]
            self.tokens = [row for row in self.tokens if row[0] is not bus]
            gone = [key for key, row in self.served.items() if row[0] is bus]
            pools = [self.served.pop(key)[2] for key in gone]
        for pool in pools:
            pool.shutdown(wait=False, cancel_futures=True)


class LatestSlot(Generic[M]):
    """The newest message of a topic."""

    def __init__(self, decode: Callable[[RawReceived], Received[M] | None]) -> None:
        self._decode = decode
        self._raw: RawReceived | None = None
        self._last: Received[M] | None = None
        self._changed = threading.Condition()

    def put(self, raw: RawReceived) -> None:
        """Replace what waits."""
        with self._changed:
            self._raw = raw
            self._changed.notify_all()

    def take(self) -> Received[M] | None:
        """Return the newest message that was not taken yet, or None."""
        with self._changed:
            raw, self._raw = self._raw, None
        received = None if raw is None else self._decode(raw)
        if received is not None:
            self._last = received
        return received

    def wait(self, timeout_s: float) -> Received[M] | None:
        """Return the next message that was not taken yet; None after the time-out."""
        with self._changed:
            self._changed.wait_for(lambda: self._raw is not None, timeout_s)
        return self.take()

    def last(self) -> Received[M] | None:
        """Return the newest message ever received, taken or not."""
        self.take()
        return self._last

    def age_s(self) -> float:
        """Return the time since the newest message arrived [s]."""
        last = self.last()
        return float("inf") if last is None else (time.monotonic_ns() - last.received_ns) * 1e-9


class InProcessBus(BusBase):
    """See `w2c.bus.interface.Bus`."""

    def __init__(self, hub: InProcessHub, robot: str, service: str, instance: str) -> None:
        super().__init__(robot, service, instance)
        self._hub = hub

    def latest(self, topic: Topic[M]) -> LatestSlot[M]:
        """Subscribe to the newest value."""
        slot: LatestSlot[M] = LatestSlot(
            lambda raw: self._decode(topic.message, topic.max_bytes, raw)
        )
        self._subscribe(topic.key(self.robot), slot.put)
        return slot

    def appear(self, service: str, instance: str) -> None:
        """Let a process be seen."""
        token = (self, self.robot, service, instance)
        with self._hub.lock:
            if token not in self._hub.tokens:
                self._hub.tokens.append(token)

    def disappear(self, service: str, instance: str) -> None:
        """Let it be seen no more."""
        gone = (self, self.robot, service, instance)
        with self._hub.lock:
            self._hub.tokens = [token for token in self._hub.tokens if token != gone]

    def alive(self) -> list[tuple[str, str]]:
        """Return (service, instance) of every process of this robot that is seen."""
        with self._hub.lock:
            return [
                (service, instance)
                for _, robot, service, instance in self._hub.tokens
                if robot == self.robot
            ]

    def close(self) -> None:
        """Undeclare everything."""
        self._hub.remove(self)

    def _send(self, topic: Topic[Any], key: str, payload: bytes) -> None:  # noqa: ARG002
        self._hub.deliver(RawReceived(key, payload, time.monotonic_ns()))

    def _send_raw(self, key: str, payload: bytes, priority: Priority) -> None:  # noqa: ARG002
        self._hub.deliver(RawReceived(key, payload, time.monotonic_ns()))

    def _subscribe(self, key_expression: str, deliver: Callable[[RawReceived], None]) -> None:
        with self._hub.lock:
            self._hub.subscriptions.append((self, key_expression, deliver))

    def _serve(
        self, key: str, handle: Callable[[RawReceived], tuple[bool, bytes]], workers: int
    ) -> None:
        pool = ThreadPoolExecutor(workers, thread_name_prefix=key.rsplit("/", 1)[-1])
        with self._hub.lock:
            self._hub.served[key] = (self, handle, pool)

    def _ask(
        self, method: Method[Any, Any], payload: bytes, timeout_s: float, instance: str | None
    ) -> tuple[str, RawReceived]:
        wanted = method.key(self.robot, instance or "*")
        with self._hub.lock:
            keys = sorted(k for k in self._hub.served if fnmatchcase(k, wanted))
            row = self._hub.served[keys[0]] if keys else None
        if row is None:
            raise self._unavailable(method)
        raw = RawReceived(keys[0], payload, time.monotonic_ns())
        try:
            done, reply = row[2].submit(row[1], raw).result(timeout_s)
        except FutureTimeoutError as error:
            raise DeadlineError(
                f"{method.service}/{method.name}: no answer within {timeout_s:.1f} s"
            ) from error
        if not done:
            self._raise_error_reply(method, reply)
        return keys[0].split("/")[-2], RawReceived(keys[0], reply, time.monotonic_ns())


def _matches(pattern: str, key: str) -> bool:
    """Tell whether a key expression (`*` = one chunk, `**` = any number) matches a key."""
    if "**" in pattern:
        return fnmatchcase(key, pattern.replace("**", "*"))
    wanted, have = pattern.split("/"), key.split("/")
    return len(wanted) == len(have) and all(
        w in ("*", h) for w, h in zip(wanted, have, strict=True)
    )
