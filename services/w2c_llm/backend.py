"""What a language model must be able to do, whatever runs it."""

import threading
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from w2c.clock import Clock
from w2c.errors import DeadlineError, W2CError
from w2c.messages import ChatMessage

JsonSchema = dict[str, Any]
"""A schema that `schema.check_schema` let through."""


@dataclass(frozen=True)
class Capabilities:
    """What a backend promises. The answer is checked against the schema whatever it promises."""

    constrained: bool
    """Answers fit the schema by construction (unless they were cut off)"""
    likelihoods: bool
    """Options are scored by their exact likelihood; else the model is asked to name one"""
    seed: bool
    """Sampling is reproducible"""
    prefix_reuse: bool
    """Leading messages that stay the same are evaluated once"""
    concurrent_calls: int
    """How many threads may use the backend at once; 1 = it has one owner"""


@dataclass(frozen=True)
class Sampling:
    """How the next token is chosen."""

    temperature: float
    """0 = the most likely one"""
    seed: int
    max_tokens: int


@dataclass(frozen=True)
class Usage:
    """What one call cost. Times in ms, the rest in tokens."""

    prompt_tokens: int = 0
    reused_tokens: int = 0
    completion_tokens: int = 0
    prefill_ms: float = 0.0
    decode_ms: float = 0.0

    def __add__(self, other: "Usage") -> "Usage":
        """Return the cost of two calls."""
        return Usage(
            self.prompt_tokens + other.prompt_tokens,
            self.reused_tokens + other.reused_tokens,
            self.completion_tokens + other.completion_tokens,
            self.prefill_ms + other.prefill_ms,
            self.decode_ms + other.decode_ms,
        )


@dataclass(frozen=True)
class Generation:
    """Text of a model, not yet checked."""

    text: str
    complete: bool
    """False: cut off at the limit of tokens"""
    usage: Usage


@dataclass(frozen=True)
class Scores:
    """Log-likelihood of each option, as the whole answer, in the order of the request."""

    log_likelihoods: list[float]
    usage: Usage


class Budget:
    """Time and cancellation of one request. Backends call `check` between units of work."""

    def __init__(self, clock: Clock, timeout_s: float) -> None:
        self._clock = clock
        self._timeout_s = timeout_s
        self._deadline_ns = clock.now_ns() + int(timeout_s * 1e9)
        self._cancelled: W2CError | None = None
        self._lock = threading.Lock()

    def cancel(self, error: W2CError) -> None:
        """End the request with this error at its next check; the first cancellation counts."""
        with self._lock:
            self._cancelled = self._cancelled or error

    def remaining_s(self) -> float:
        """Return the time that is left [s], not below zero."""
        return max(0.0, (self._deadline_ns - self._clock.now_ns()) * 1e-9)

    def check(self) -> None:
        """Raise the error of the cancellation, or DeadlineError when the time is over."""
        if self._cancelled is not None:
            raise self._cancelled
        if self.remaining_s() <= 0.0:
            raise DeadlineError(
                f"the language model took longer than {self._timeout_s:g} s; "
                "use a smaller model, fewer tokens or a longer --deadline"
            )


class Backend(Protocol):
    """One loaded model, or one remote one."""

    @property
    def name(self) -> str:
        """Name of the model, for replies and recordings."""

    @property
    def capabilities(self) -> Capabilities:
        """What it promises."""

    def generate(
        self,
        messages: Sequence[ChatMessage],
        schema: JsonSchema,
        sampling: Sampling,
        constant_messages: int,
        budget: Budget,
    ) -> Generation:
        """Continue a chat with JSON of a schema.

        Raises:
            RefusedError: this model cannot serve the request (too long, schema not supported).
            DeadlineError: the budget is spent.
            ModelError: the model failed.
        """

    def score(
        self,
        messages: Sequence[ChatMessage],
        options: Sequence[str],
        constant_messages: int,
        budget: Budget,
    ) -> Scores:
        """Return how likely each option is as the whole answer. Raises as `generate` does."""

    def warm_up(self) -> None:
        """Run the model once, so that the first request is not the slow one."""

    def close(self) -> None:
        """Release the model. Idempotent."""
