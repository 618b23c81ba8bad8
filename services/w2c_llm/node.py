"""Bus in, bus out: requests to the engine, answers with what they cost."""

import logging
import os
import threading
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from w2c import topics
from w2c.bus import Bus
from w2c.bus.interface import CallContext
from w2c.clock import Clock
from w2c.errors import ConfigError, W2CError
from w2c.extras import needs_extra
from w2c.messages import ChooseReply, ChooseRequest, CompleteReply, CompleteRequest
from w2c_llm import answering
from w2c_llm.backend import Backend, Budget, Usage
from w2c_llm.config import EMBEDDED_MODEL, LlmConfig
from w2c_llm.engine import Done, Engine
from w2c_llm.metrics import Metrics

_LOG = logging.getLogger("w2c.llm")
Answer = TypeVar("Answer", answering.Completion, answering.Choice)


_CAUSES = {
    "unavailable": "request rejected: queue full or stopping",
    "deadline": "request given up: deadline",
    "refused": "request refused",
    "model": "request failed in the model",
}
"""What the health report counts, by the code of the error"""


class LlmNode:
    """Serves `llm/complete` and `llm/choose`."""

    def __init__(self, config: LlmConfig, bus: Bus, clock: Clock) -> None:
        self._config = config
        self._bus = bus
        self._clock = clock
        self._engine = Engine(self._load, capacity=config.queue, clock=clock)
        self._metrics = Metrics()
        self._name = ""

    @property
    def queue_length(self) -> int:
        """Requests that wait, for the health report."""
        return self._engine.queue_length

    @property
    def detail(self) -> str:
        """Time of the latest requests in queue, prompt and answer, for the health report."""
        return self._metrics.summary()

    def configure(self) -> None:
        """Load and warm up the model, then serve."""
        self._engine.start()
        # Handlers only wait for the engine: enough of them to fill its queue, which is what bounds
        # the load.
        workers = self._config.queue + 1
        self._bus.serve(topics.COMPLETE, self.complete, workers=workers)
        self._bus.serve(topics.CHOOSE, self.choose, workers=workers)

    def run(self, stop: threading.Event) -> None:
        """Wait for the end: all work is in the handlers and on the engine's thread."""
        stop.wait()

    def close(self) -> None:
        """Stop the engine; what waits gets an error that its caller may retry elsewhere."""
        self._engine.close()

    def complete(self, request: CompleteRequest, _: CallContext) -> CompleteReply:
        """Answer one `complete`."""
        done = self._answer(
            lambda backend, budget: answering.complete(backend, request, budget), request.deadline
        )
        answer, usage = done.value, done.value.usage
        return CompleteReply(
            text=answer.text,
            value=answer.value,
            model=self._name,
            prompt_tokens=usage.prompt_tokens,
            reused_tokens=usage.reused_tokens,
            completion_tokens=usage.completion_tokens,
            queue_ms=done.queue_ms,
            prefill_ms=usage.prefill_ms,
            decode_ms=usage.decode_ms,
        )

    def choose(self, request: ChooseRequest, _: CallContext) -> ChooseReply:
        """Answer one `choose`."""
        done = self._answer(
            lambda backend, budget: answering.choose(backend, request, budget), request.deadline
        )
        choice, usage = done.value, done.value.usage
        return ChooseReply(
            option=choice.option,
            probabilities=choice.probabilities,
            model=self._name,
            prompt_tokens=usage.prompt_tokens,
            reused_tokens=usage.reused_tokens,
            queue_ms=done.queue_ms,
            prefill_ms=usage.prefill_ms,
        )

    def _answer(
        self, work: Callable[[Backend, Budget], Answer], deadline: float | None
    ) -> Done[Answer]:
        """Run a request on the model; count what it cost, or why it failed."""
        seconds = min(deadline or self._config.deadline, self._config.deadline)
        try:
            done = self._engine.submit(work, seconds)
        except W2CError as error:
            self._bus.count(_CAUSES.get(error.code, error.code))
            raise
        usage: Usage = done.value.usage
        self._metrics.add(done.queue_ms, usage)
        return done

    def _load(self) -> Backend:
        """Load the configured model; on the engine's thread."""
        backend = make_backend(self._config)
        self._name = backend.name
        _LOG.info("model loaded", extra={"model": backend.name, "backend": self._config.backend})
        return backend


def make_backend(config: LlmConfig) -> Backend:
    """Return the backend that the flags name.

    Raises:
        ConfigError: a file is missing, or the flags do not fit each other.
        ModelError: the model cannot be loaded.
    """
    with needs_extra("llm"):
        if config.backend == "openai":
            return _make_openai(config)
        if config.backend == "replay":
            return _make_replay(config)
        return _make_llama_cpp(config)


def _make_llama_cpp(config: LlmConfig) -> Backend:
    from w2c_llm.llama_cpp_backend import LlamaCppBackend

    path = Path(config.model) if config.model else EMBEDDED_MODEL
    several = max(1, (os.cpu_count() or 1) // 2)
    threads = config.threads or (1 if path == EMBEDDED_MODEL else several)
    return LlamaCppBackend(
        path,
        context=config.context,
        threads=threads,
        gpu_layers=config.gpu_layers,
        constraint=config.constraint,
    )


def _make_replay(config: LlmConfig) -> Backend:
    from w2c_llm.replay_backend import ReplayBackend

    if not config.model:
        raise ConfigError("--backend replay needs --model, the recording: a session.mcap")
    return ReplayBackend(Path(config.model))


def _make_openai(config: LlmConfig) -> Backend:
    from w2c.chat_server import read_key
    from w2c_llm.openai_backend import OpenAiBackend, OpenAiOptions

    if not config.model:
        raise ConfigError("--backend openai needs --model, the name of the model at the server")
    options = OpenAiOptions(
        url=config.openai_url,
        model=config.model,
        schema_mode=config.openai_schema,
        sampling=config.openai_sampling,
        token_limit=config.openai_token_limit,
        logprobs=config.openai_logprobs,
        concurrency=config.openai_concurrency,
    )
    return OpenAiBackend(options, read_key(config.openai_key_file))
