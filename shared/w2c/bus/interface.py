"""What a service sees of the bus."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar

from w2c.bus.codec import Envelope, Input
from w2c.messages import Message
from w2c.topics import Method, Priority, Topic

M = TypeVar("M", bound=Message)
M_co = TypeVar("M_co", bound=Message, covariant=True)
Request = TypeVar("Request", bound=Message)
Reply = TypeVar("Reply", bound=Message)


@dataclass(frozen=True)
class Received(Generic[M_co]):
    """A message with its envelope."""

    message: M_co
    key: str
    envelope: Envelope
    received_ns: int
    """Monotonic clock of the receiver [ns]"""

    def as_input(self) -> Input:
        """Return the reference that a message computed from this one carries in its `inputs`."""
        return Input(key=self.key, boot_id=self.envelope.boot_id, sequence=self.envelope.sequence)


@dataclass(frozen=True)
class RawReceived:
    """The bytes of a message exactly as they were on the wire."""

    key: str
    payload: bytes
    received_ns: int
    """Monotonic clock of the receiver [ns]"""


@dataclass(frozen=True)
class CallContext:
    """What a handler may know of the call it serves, beside the request."""

    caller: str
    request: Received[Any]


class Latest(Protocol[M_co]):
    """The newest message of a topic; older ones are dropped, which is the point."""

    def take(self) -> Received[M_co] | None:
        """Return the newest message that was not taken yet, or None. Never blocks."""

    def wait(self, timeout_s: float) -> Received[M_co] | None:
        """Return the next message that was not taken yet; None after the time-out."""

    def last(self) -> Received[M_co] | None:
        """Return the newest message ever received, taken or not; None before the first."""

    def age_s(self) -> float:
        """Return the time since the newest message arrived [s]; infinity before the first."""


class Queue(Protocol[M_co]):
    """Every message of a topic in order. When it is full the oldest is dropped, and counted."""

    def receive(self, timeout_s: float) -> Received[M_co] | None:
        """Return the next message; None after the time-out."""


class RawQueue(Protocol):
    """Every message of a key expression in order, not decoded. Full: the oldest drops."""

    def receive(self, timeout_s: float) -> RawReceived | None:
        """Return the next message; None after the time-out."""


class Bus(Protocol):
    """The connection of one process. Thread-safe."""

    @property
    def robot(self) -> str:
        """Id of the robot whose keys are used."""

    @property
    def service(self) -> str:
        """Name of this process on the keys."""

    @property
    def instance(self) -> str:
        """Which replica of the service this is."""

    @property
    def boot_id(self) -> str:
        """New at each start of the process."""

    @property
    def counters(self) -> dict[str, int]:
        """Drops and refusals since the start, by cause: `dropped <key>`, `malformed <key>` ..."""

    def count(self, cause: str) -> None:
        """Add one to a cause of loss: what a service itself drops or refuses."""

    def publish(self, topic: Topic[M], message: M, inputs: Sequence[Input] = ()) -> Input:
        """Send a message. Returns the reference to it, for the `inputs` of later messages."""

    def latest(self, topic: Topic[M]) -> Latest[M]:
        """Subscribe to the newest value."""

    def queue(self, topic: Topic[M], size: int = 1000) -> Queue[M]:
        """Subscribe to every message."""

    def raw_queue(self, key_expression: str, size: int = 10_000) -> RawQueue:
        """Subscribe to the bytes of every key that matches, for the recorder."""

    def use_lock_step(self) -> None:
        """From now on block, instead of drop, on the links that lock step must not lose."""

    def serve(
        self,
        method: Method[Request, Reply],
        handler: Callable[[Request, CallContext], Reply],
        *,
        workers: int = 1,
    ) -> None:
        """Answer a method. A W2CError of the handler becomes the caller's error, with its message.

        `workers` handlers run at once at most, each on a thread of its own; more calls wait.
        """

    def call(
        self,
        method: Method[Request, Reply],
        request: Request,
        *,
        timeout_s: float | None = None,
        inputs: Sequence[Input] = (),
        instance: str | None = None,
    ) -> Received[Reply]:
        """Ask the replica with the shortest queue and return its reply; publishes the trace.

        `instance` names one replica instead: what is said to it holds for no other.

        Raises:
            UnavailableError: nobody serves the method, or the process died meanwhile.
            DeadlineError: no reply before the deadline (the method's own where None).
            RefusedError: the service refuses, with a reason for the operator.
            RemoteError: the service failed.
        """

    def alive(self) -> list[tuple[str, str]]:
        """Return (service, instance) of every process whose liveliness token is seen."""

    def close(self) -> None:
        """Stop serving, undeclare everything. Idempotent."""


class StandIn(Protocol):
    """What a replay of a recording does in the name of processes that are not there."""

    @property
    def robot(self) -> str:
        """Id of the robot whose keys are used, the only one that it may speak of."""

    @property
    def instance(self) -> str:
        """Which replay this is."""

    def publish_raw(self, key: str, payload: bytes, priority: Priority) -> None:
        """Send the bytes of a message; waits where the link is full. Raises MessageError."""

    def answer_raw(self, key: str, payload: bytes) -> None:
        """Answer every call of a key with these bytes, from now on. Raises MessageError."""

    def refuse_raw(self, key: str, reason: str) -> None:
        """Let every call of a key fail as unavailable, from now on. Raises MessageError."""

    def appear(self, service: str, instance: str) -> None:
        """Let a process be seen. Idempotent."""

    def disappear(self, service: str, instance: str) -> None:
        """Let it be seen no more. Idempotent."""

    def alive(self) -> list[tuple[str, str]]:
        """Return (service, instance) of every process that is seen."""

    def raw_queue(self, key_expression: str, size: int = 10_000) -> RawQueue:
        """Subscribe to the bytes of every key that matches."""
