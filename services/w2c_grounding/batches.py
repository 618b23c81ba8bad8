"""Requests wait in one bounded queue; one thread answers, those about one picture together.

One thread owns the model, so that a model can be taken away between two requests, and so that torch
keeps one set of worker threads instead of one for each caller.
"""

import hashlib
import threading
from collections import deque
from collections.abc import Callable
from concurrent.futures import CancelledError, Future
from dataclasses import dataclass, field
from typing import TypeVar

from w2c.clock import Clock
from w2c.errors import DeadlineError, UnavailableError
from w2c.messages import GroundingReply, GroundingRequest

T = TypeVar("T")

_LONGEST_CLOSE_S = 10.0
"""How long the end of the process waits for the answer that is being made"""

AnswerTogether = Callable[[list[GroundingRequest]], list[GroundingReply]]
"""Requests about one picture in, a reply for each in their order out"""

MAX_PHRASES = 64
"""Of requests that are answered together: bounds memory, and how long the next picture waits"""


@dataclass(frozen=True)
class Answered:
    """A reply, and what it took to get it."""

    reply: GroundingReply
    queue_ms: float
    """From asking to the beginning of the work"""
    together: int
    """How many requests were answered in the same go"""


@dataclass(frozen=True, eq=False)
class _Job:
    request: GroundingRequest
    picture: bytes
    asked_ns: int
    future: "Future[Answered]" = field(default_factory=Future)


class BatchQueue:
    """Answers requests in order of arrival. Thread-safe."""

    def __init__(
        self, answer: AnswerTogether, *, limit: int, patience_s: float, clock: Clock
    ) -> None:
        """Prepare; nothing runs before `start`.

        Args:
            answer: Called on the owner thread only.
            limit: Requests that may wait while one is answered; one more is refused.
            patience_s: A request that waited longer is given up: its caller has gone.
            clock: For waiting times.
        """
        self._answer = answer
        self._limit = limit
        self._patience_s = patience_s
        self._clock = clock
        self._changed = threading.Condition()
        self._waiting: deque[_Job] = deque()
        self._errands: deque[Callable[[], None]] = deque()
        self._busy = 0
        self._closed = False
        self._thread = threading.Thread(target=self._own, name="grounding", daemon=True)

    @property
    def waiting(self) -> int:
        """Requests that wait, without those that are being answered."""
        return len(self._waiting)

    def start(self) -> None:
        """Begin to answer."""
        self._thread.start()

    def ask(self, request: GroundingRequest) -> Answered:
        """Wait for the answer to a request.

        Raises:
            UnavailableError: too many wait, or the queue was closed.
            DeadlineError: it waited too long.
            W2CError: what the answer raised.
        """
        digest = hashlib.blake2b(request.jpeg, digest_size=16).digest()
        job = _Job(request, digest, self._clock.now_ns())
        with self._changed:
            if self._closed:
                raise UnavailableError("grounding is shutting down; ask another replica")
            if len(self._waiting) + bool(self._busy) > self._limit:
                raise UnavailableError(
                    f"grounding is busy: {len(self._waiting)} requests wait, limit {self._limit}; "
                    "ask again, or start another replica with --instance"
                )
            self._waiting.append(job)
            self._changed.notify()
        return _result(job.future)

    def between(self, errand: Callable[[], T]) -> T:
        """Run something on the owner thread, before the next request; return its result.

        Raises:
            UnavailableError: the queue was closed.
        """
        done: Future[T] = Future()
        with self._changed:
            if self._closed:
                raise UnavailableError("grounding is shutting down; ask another replica")
            self._errands.append(lambda: _settle(done, errand))
            self._changed.notify()
        return _result(done)

    def close(self) -> None:
        """Finish what is being answered, refuse what waits. Idempotent."""
        with self._changed:
            self._closed = True
            for job in self._waiting:
                job.future.cancel()
            self._waiting.clear()
            self._changed.notify()
        if self._thread.is_alive():
            self._thread.join(timeout=_LONGEST_CLOSE_S)

    def _own(self) -> None:
        # A turn has a frame of its own: nothing of it, a model that was let go for one, is held
        # while the next is awaited.
        while self._turn():
            pass

    def _turn(self) -> bool:
        """Wait for work and do it; False where none will come."""
        with self._changed:
            self._changed.wait_for(lambda: self._errands or self._waiting or self._closed)
            errand = self._errands.popleft() if self._errands else None
            jobs = self._take() if errand is None and self._waiting else []
            self._busy = len(jobs)
        if errand is not None:
            errand()
        elif jobs:
            self._answer_all(jobs)
        else:
            return False
        with self._changed:
            self._busy = 0
        return True

    def _take(self) -> list[_Job]:
        """Remove and return the oldest request and those that are about its picture too."""
        first = self._waiting.popleft()
        taken, phrases = [first], len(first.request.phrases)
        for job in [job for job in self._waiting if job.picture == first.picture]:
            phrases += len(job.request.phrases)
            if phrases > MAX_PHRASES:
                break
            taken.append(job)
            self._waiting.remove(job)
        return taken

    def _answer_all(self, jobs: list[_Job]) -> None:
        """Answer the jobs; whatever is raised goes to their callers, and the thread lives on."""
        now = self._clock.now_ns()
        live = []
        for job in jobs:
            if (now - job.asked_ns) * 1e-9 > self._patience_s:
                job.future.set_exception(
                    DeadlineError(
                        f"the request waited longer than {self._patience_s:g} s; grounding is too "
                        "slow for what is asked of it: use a smaller model, or more replicas"
                    )
                )
            else:
                live.append(job)
        if not live:
            return
        try:
            replies = self._answer([job.request for job in live])
        except Exception as error:
            if len(live) == 1:
                live[0].future.set_exception(error)
                return
            # One of them may have spoiled it for the others.
            for job in live:
                self._answer_all([job])
            return
        for job, reply in zip(live, replies, strict=True):
            job.future.set_result(Answered(reply, (now - job.asked_ns) * 1e-6, len(live)))


def _settle(done: "Future[T]", errand: Callable[[], T]) -> None:
    try:
        done.set_result(errand())
    except Exception as error:
        done.set_exception(error)


def _result(future: "Future[T]") -> T:
    try:
        return future.result()
    except CancelledError:
        raise UnavailableError("grounding was shut down before the request ran") from None
