"""One thread owns a model; others hand it work through a bounded queue and wait with a deadline.

llama.cpp aborts the process when two threads use one context, so the rule is structural: the
backend is made, used and closed on the owner thread, and nobody else has a reference to it.
"""

import queue
import threading
import time
from collections.abc import Callable
from concurrent.futures import CancelledError, Future
from concurrent.futures import TimeoutError as FutureTimeout
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from w2c.clock import Clock, RealClock
from w2c.errors import DeadlineError, ModelError, UnavailableError, W2CError
from w2c_llm.backend import Backend, Budget

T = TypeVar("T")

Work = Callable[[Backend, Budget], T]

_GRACE_S = 1.0
"""How long a caller waits beyond its deadline for the owner to notice it"""


@dataclass(frozen=True)
class Done(Generic[T]):
    """A result, and how long the request waited before its turn."""

    value: T
    queue_ms: float


@dataclass(frozen=True)
class _Job:
    work: Work[Any]
    budget: Budget
    future: "Future[Done[Any]]"
    submitted: float


class Engine:
    """Runs work on one backend, in order of arrival."""

    def __init__(
        self, make_backend: Callable[[], Backend], *, capacity: int = 16, clock: Clock | None = None
    ) -> None:
        """Prepare; nothing is loaded before `start`.

        Args:
            make_backend: Loads the model; called on the owner thread.
            capacity: Requests that may wait; one more is refused.
            clock: For deadlines, which are wall time.
        """
        self._make_backend = make_backend
        self._capacity = capacity
        self._clock = clock or RealClock()
        self._queue: queue.Queue[_Job | None] = queue.Queue()
        self._threads: list[threading.Thread] = []
        self._lock = threading.Lock()
        self._waiting = 0
        self._running: set[Budget] = set()
        self._closed = False

    @property
    def queue_length(self) -> int:
        """Requests that wait, without the one that runs."""
        return self._waiting

    def start(self, timeout_s: float = 600.0) -> None:
        """Load the model and warm it up.

        Raises:
            ModelError: it took too long.
            W2CError: the model cannot be loaded; the error of `make_backend`.
        """
        loaded: Future[int] = Future()
        self._spawn(lambda: self._own(loaded))
        # A backend that several threads may use (a remote one) gets more of them.
        try:
            concurrent_calls = loaded.result(timeout_s)
        except FutureTimeout:
            raise ModelError(
                f"the model was not loaded within {timeout_s:g} s; use a smaller one"
            ) from None
        for _ in range(concurrent_calls - 1):
            self._spawn(lambda: self._serve(self._backend))

    def submit(self, work: Work[T], timeout_s: float) -> Done[T]:
        """Run work on the model's thread and return its result. Safe from any thread.

        Raises:
            UnavailableError: the queue is full, or the engine stops.
            DeadlineError: the result did not come in time; the work is cancelled.
            W2CError: what the work raised.
        """
        job = _Job(work, Budget(self._clock, timeout_s), Future(), time.monotonic())
        with self._lock:
            if self._closed or not self._threads:
                raise UnavailableError(
                    "the language model is not running; is the llm service ready?"
                )
            if self._waiting >= self._capacity:
                raise UnavailableError(
                    f"{self._waiting} requests wait for the model, limit {self._capacity}; "
                    "try again later, or start another replica"
                )
            self._waiting += 1
            self._queue.put(job)
        try:
            return job.future.result(timeout_s + _GRACE_S)
        except FutureTimeout:
            late = DeadlineError(f"the language model gave no answer within {timeout_s:g} s")
            job.budget.cancel(late)
            raise late from None
        except CancelledError:
            raise UnavailableError(
                "the language model was stopped before the request ran"
            ) from None

    def close(self) -> None:
        """Cancel what runs and waits, close the model. Idempotent."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
            stopping = UnavailableError("the language model is being stopped")
            for budget in self._running:
                budget.cancel(stopping)
            self._cancel_waiting()
            for _ in self._threads:
                self._queue.put(None)
        # The owner comes first and closes the backend: it waits for the others.
        for thread in reversed(self._threads):
            thread.join(timeout=10.0)

    def _spawn(self, target: Callable[[], None]) -> None:
        thread = threading.Thread(target=target, name=f"model-{len(self._threads)}", daemon=True)
        self._threads.append(thread)
        thread.start()

    def _cancel_waiting(self) -> None:
        while True:
            try:
                job = self._queue.get_nowait()
            except queue.Empty:
                return
            if job is not None:
                self._waiting -= 1
                job.future.cancel()

    def _own(self, loaded: "Future[int]") -> None:
        """Life of the owner thread: load, warm up, serve, close."""
        try:
            self._backend = self._make_backend()
        except BaseException as error:  # whatever it is, the waiting caller must get it
            loaded.set_exception(error)
            return
        try:
            try:
                self._backend.warm_up()
            except BaseException as error:  # as above
                loaded.set_exception(error)
                return
            loaded.set_result(self._backend.capabilities.concurrent_calls)
            self._serve(self._backend)
            for thread in self._threads[1:]:
                thread.join(timeout=10.0)
        finally:
            self._backend.close()

    def _serve(self, backend: Backend) -> None:
        while (job := self._queue.get()) is not None:
            with self._lock:
                self._waiting -= 1
                self._running.add(job.budget)
            try:
                self._run(backend, job)
            finally:
                with self._lock:
                    self._running.discard(job.budget)

    def _run(self, backend: Backend, job: _Job) -> None:
        """Run one job; whatever it raises goes to its caller, and the thread lives on."""
        queue_ms = 1e3 * (time.monotonic() - job.submitted)
        try:
            job.budget.check()  # it may have waited too long: then nothing is evaluated for it
            job.future.set_result(Done(job.work(backend, job.budget), queue_ms))
        except W2CError as error:
            job.future.set_exception(error)
        except Exception as error:
            failure = ModelError(f"the language model failed: {type(error).__name__}: {error}")
            failure.__cause__ = error
            job.future.set_exception(failure)
