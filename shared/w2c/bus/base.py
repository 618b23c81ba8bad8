"""What both buses do alike: envelopes, validation, counting what is dropped, tracing of calls."""

import itertools
import threading
import time
import uuid
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from types import TracebackType
from typing import Any, Self, TypeVar

from w2c import topics
from w2c.bus.codec import (
    ENVELOPE_VERSION,
    Envelope,
    Input,
    decode_envelope,
    encode_envelope,
    validate,
)
from w2c.bus.interface import CallContext, RawReceived, Received
from w2c.bus.mailbox import DecodingQueue, Mailbox
from w2c.errors import (
    CallError,
    DeadlineError,
    MessageError,
    RemoteError,
    UnavailableError,
    W2CError,
    error_codes,
)
from w2c.messages import CallTrace, ErrorReply, Message
from w2c.topics import Method, Priority, Topic

M = TypeVar("M", bound=Message)
Request = TypeVar("Request", bound=Message)
Reply = TypeVar("Reply", bound=Message)


class BusBase(ABC):
    """A bus without a transport."""

    def __init__(self, robot: str, service: str, instance: str) -> None:
        self.robot = robot
        self.service = service
        self.instance = instance
        self.boot_id = uuid.uuid4().hex[:16]
        self.lock_step = False
        self._sequences: dict[str, Iterator[int]] = {}
        self._counters: dict[str, int] = {}
        self._raw_answers: dict[str, tuple[bool, bytes]] = {}
        self._lock = threading.Lock()

    def __enter__(self) -> Self:
        """Return the bus itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    @property
    def counters(self) -> dict[str, int]:
        """Drops and refusals since the start, by cause."""
        with self._lock:
            return dict(self._counters)

    def count(self, cause: str) -> None:
        """Add one to a cause of loss."""
        with self._lock:
            self._counters[cause] = self._counters.get(cause, 0) + 1

    def use_lock_step(self) -> None:
        """From now on block, instead of drop, on the links that lock step must not lose."""
        self.lock_step = True

    def publish(self, topic: Topic[M], message: M, inputs: Sequence[Input] = ()) -> Input:
        """Send a message. Returns the reference to it."""
        if topic.service not in ("*", self.service):
            raise MessageError(
                f"{self.service} may not write {topic.kind}/{topic.service}/{topic.name}: "
                f"the registry gives it to {topic.service}"
            )
        if type(message) is not topic.message:
            raise MessageError(
                f"{topic.kind}/{topic.service}/{topic.name} carries {topic.message.__name__}, "
                f"not {type(message).__name__}"
            )
        key = topic.key(self.robot, self.service)
        payload, sequence = self._wrap(key, message, inputs)
        if len(payload) > topic.max_bytes:
            self.count(f"oversize {key}")
            raise MessageError(f"{key}: {len(payload)} bytes, limit {topic.max_bytes}")
        self._send(topic, key, payload)
        return Input(key=key, boot_id=self.boot_id, sequence=sequence)

    def publish_raw(self, key: str, payload: bytes, priority: Priority) -> None:
        """Send the bytes of a message in another process's name, for a replay."""
        self._check_robot(key)
        self._send_raw(key, payload, priority)

    def answer_raw(self, key: str, payload: bytes) -> None:
        """Answer every call of a key with these bytes in another process's name, for a replay."""
        self._answer_raw(key, (True, payload))

    def refuse_raw(self, key: str, reason: str) -> None:
        """Let every call of a key fail as unavailable, for a replay."""
        reply = ErrorReply(code=UnavailableError.code, message=reason, retryable=True)
        self._answer_raw(key, (False, self._wrap(f"reply/{key}", reply, ())[0]))

    def queue(self, topic: Topic[M], size: int = 1000) -> DecodingQueue[M]:
        """Subscribe to every message."""
        key = topic.key(self.robot)
        mailbox: Mailbox[RawReceived] = Mailbox(size, lambda: self.count(f"overflow {key}"))
        self._subscribe(key, mailbox.put)
        return DecodingQueue(mailbox, lambda raw: self._decode(topic.message, topic.max_bytes, raw))

    def raw_queue(self, key_expression: str, size: int = 10_000) -> Mailbox[RawReceived]:
        """Subscribe to the bytes of every key that matches."""
        mailbox: Mailbox[RawReceived] = Mailbox(
            size, lambda: self.count(f"overflow {key_expression}")
        )
        self._subscribe(key_expression, mailbox.put)
        return mailbox

    def serve(
        self,
        method: Method[Request, Reply],
        handler: Callable[[Request, CallContext], Reply],
        *,
        workers: int = 1,
    ) -> None:
        """Answer a method."""
        key = method.key(self.robot, self.instance)
        self._serve(key, lambda raw: self._handle(method, handler, raw), workers)

    def call(
        self,
        method: Method[Request, Reply],
        request: Request,
        *,
        timeout_s: float | None = None,
        inputs: Sequence[Input] = (),
        instance: str | None = None,
    ) -> Received[Reply]:
        """Ask a replica, any or the named one, and return its reply; publishes the trace."""
        timeout = method.timeout_s if timeout_s is None else timeout_s
        key = f"{method.service}/{method.name}"
        payload, _ = self._wrap(f"call/{key}", request, inputs)
        if len(payload) > method.max_bytes:
            raise MessageError(f"request {key}: {len(payload)} bytes, limit {method.max_bytes}")
        started = time.monotonic()
        outcome, answer, asked, problem = "ok", b"", instance or "", ""
        try:
            asked, raw = self._ask(method, payload, timeout, instance)
            answer = raw.payload
            received = self._decode(method.reply, method.max_bytes, raw)
            if received is None:
                raise RemoteError(
                    f"{key} answered with something that is no {method.reply.__name__}"
                )
            return received
        except CallError as error:
            outcome, problem = error.code, str(error)
            raise
        finally:
            trace = CallTrace(
                service=method.service,
                method=method.name,
                instance=asked,
                outcome=outcome,
                duration_ms=(time.monotonic() - started) * 1e3,
                request=payload,
                reply=answer,
                error=problem[:20_000],
            )
            self.publish(topics.TRACE, trace)

    def _wrap(self, key: str, message: Message, inputs: Sequence[Input]) -> tuple[bytes, int]:
        """Return the bytes of the message in its envelope, and its sequence number on the key."""
        # Without a lock: a loop with deadlines must not wait for a thread that is not running.
        counter = self._sequences.get(key) or self._sequences.setdefault(key, itertools.count())
        sequence = next(counter)
        envelope = Envelope(
            version=ENVELOPE_VERSION,
            robot=self.robot,
            sender=self.service,
            boot_id=self.boot_id,
            sequence=sequence,
            monotonic_ns=time.monotonic_ns(),
            clock_ns=time.time_ns(),
            inputs=list(inputs),
            data=message,
        )
        return encode_envelope(envelope), sequence

    def _decode(self, message_type: type[M], limit: int, raw: RawReceived) -> Received[M] | None:
        """Return the message, or None for bytes that are none: counted, not raised."""
        try:
            envelope = decode_envelope(raw.payload, limit)
            message = validate(envelope.data, message_type)
        except MessageError:
            self.count(f"malformed {raw.key}")
            return None
        return Received(
            message=message, key=raw.key, envelope=envelope, received_ns=raw.received_ns
        )

    def _handle(
        self,
        method: Method[Request, Reply],
        handler: Callable[[Request, CallContext], Reply],
        raw: RawReceived,
    ) -> tuple[bool, bytes]:
        """Run a handler. Returns (True, reply) or (False, ErrorReply): nothing escapes."""
        try:
            envelope = decode_envelope(raw.payload, method.max_bytes)
            request = validate(envelope.data, method.request)
        except MessageError as error:
            self.count(f"malformed {method.service}/{method.name}")
            return False, self._error(method, "refused", str(error), retryable=False)
        received = Received(request, raw.key, envelope, raw.received_ns)
        try:
            reply = handler(request, CallContext(caller=envelope.sender, request=received))
        except W2CError as error:
            code = error.code if error.code in error_codes() else "refused"
            return False, self._error(method, code, str(error), retryable=error.retryable)
        except Exception as error:  # the boundary: the caller must get an answer, whatever broke
            self.count(f"failed {method.service}/{method.name}")
            self._log_failure(method, error)
            return False, self._error(
                method, "remote", f"{type(error).__name__}: {error}", retryable=False
            )
        try:
            return True, self._wrap(
                f"reply/{method.service}/{method.name}", reply, [received.as_input()]
            )[0]
        except MessageError as error:
            self.count(f"failed {method.service}/{method.name}")
            return False, self._error(method, "remote", f"the reply: {error}", retryable=False)

    def _log_failure(self, method: Method[Any, Any], error: Exception) -> None:
        import logging

        logging.getLogger("w2c.bus").error(
            "%s/%s failed",
            method.service,
            method.name,
            exc_info=(type(error), error, error.__traceback__),
        )

    def _error(self, method: Method[Any, Any], code: str, text: str, *, retryable: bool) -> bytes:
        sendable = text[:20_000].encode("utf-8", "replace").decode()
        reply = ErrorReply(code=code, message=sendable, retryable=retryable)
        return self._wrap(f"reply/{method.service}/{method.name}", reply, ())[0]

    def _raise_error_reply(self, method: Method[Any, Any], payload: bytes) -> None:
        """Raise the typed error that an error reply stands for."""
        if payload == b"Timeout":  # Zenoh's own word for a deadline
            raise DeadlineError(f"{method.service}/{method.name}: no answer in time")
        try:
            reply = validate(decode_envelope(payload, method.max_bytes).data, ErrorReply)
        except MessageError as error:
            raise RemoteError(
                f"{method.service}/{method.name}: unreadable error reply: {error}"
            ) from error
        raise error_codes().get(reply.code, RemoteError)(reply.message)

    def _answer_raw(self, key: str, answer: tuple[bool, bytes]) -> None:
        self._check_robot(key)
        with self._lock:
            is_served = key in self._raw_answers
            self._raw_answers[key] = answer
        if not is_served:
            self._serve(key, lambda _raw: self._raw_answers[key], 1)

    def _check_robot(self, key: str) -> None:
        """Raise MessageError for a key of another robot: a replay speaks of its own only."""
        if not key.startswith(f"w2c/{topics.VERSION}/{self.robot}/"):
            raise MessageError(f"{key} is not of {self.robot}, the robot of this connection")

    def _unavailable(self, method: Method[Any, Any]) -> UnavailableError:
        if any(service == method.service for service, _ in self.alive()):
            return UnavailableError(
                f"the {method.service} process is there and does not take "
                f"{method.service}/{method.name} yet: it is still starting, or this process has no "
                "right to ask. Ask again when it is ready: w2c status"
            )
        return UnavailableError(
            f"nobody serves {method.service}/{method.name}; "
            f"is the {method.service} process running? Look with: w2c status"
        )

    @abstractmethod
    def alive(self) -> list[tuple[str, str]]:
        """Return (service, instance) of every process that is seen."""

    @abstractmethod
    def close(self) -> None:
        """Stop serving, undeclare everything. Idempotent."""

    @abstractmethod
    def _send(self, topic: Topic[Any], key: str, payload: bytes) -> None:
        """Put bytes on the wire."""

    @abstractmethod
    def _send_raw(self, key: str, payload: bytes, priority: Priority) -> None:
        """Put bytes on the wire, and wait where it is full."""

    @abstractmethod
    def _subscribe(self, key_expression: str, deliver: Callable[[RawReceived], None]) -> None:
        """Deliver the bytes of every matching key, on a thread of the bus."""

    @abstractmethod
    def _serve(
        self, key: str, handle: Callable[[RawReceived], tuple[bool, bytes]], workers: int
    ) -> None:
        """Answer calls of a key: (True, reply) or (False, ErrorReply), on threads of its own."""

    @abstractmethod
    def _ask(
        self, method: Method[Any, Any], payload: bytes, timeout_s: float, instance: str | None
    ) -> tuple[str, RawReceived]:
        """Return (instance, reply bytes) of one replica, the named one if any. Raises CallError."""
