"""Grounding on the bus: serves `grounding/ground` and `grounding/use`."""

import logging
import threading

import psutil

from w2c import topics
from w2c.bus import Bus, CallContext
from w2c.clock import Clock
from w2c.errors import ModelError, RefusedError, UnavailableError, W2CError
from w2c.messages import GroundingReply, GroundingRequest, UseModelReply, UseModelRequest
from w2c_grounding.batches import BatchQueue
from w2c_grounding.config import Config
from w2c_grounding.guard import is_device_lost
from w2c_grounding.loaded import Load, LoadedModel, another, give_memory_back, load_model
from w2c_grounding.metrics import Metrics
from w2c_grounding.registry import load as load_registered
from w2c_grounding.together import ground_together

LOOK_PERIOD_S = 0.2
"""Between looks at whether the GPU is still there"""

_LOG = logging.getLogger("w2c.grounding")

_CAUSES = {
    "unavailable": "request rejected: queue full or stopping",
    "deadline": "request given up: deadline",
    "refused": "request refused",
    "model": "request failed in the model",
}
"""What the health report counts, by the code of the error"""


class GroundingNode:
    """One replica. Stateless: what it remembers of pictures only saves time."""

    def __init__(
        self, config: Config, bus: Bus, clock: Clock, load: Load = load_registered
    ) -> None:
        self._config = config
        self._bus = bus
        self._clock = clock
        self._load = load
        self._queue = BatchQueue(
            self._answer,
            limit=config.queue_limit,
            patience_s=topics.GROUND.timeout_s,
            clock=clock,
        )
        self._metrics = Metrics()
        self._model: LoadedModel | None = None
        self._changing = threading.Lock()
        self._loading = ""
        self._lost = ""
        """What the GPU failed with, after which this process cannot use it"""

    @property
    def queue_length(self) -> int:
        """Requests that wait, for the health report."""
        return self._queue.waiting

    @property
    def detail(self) -> str:
        """The model, what answers cost, and what is being loaded, for the health report."""
        model = self._model
        parts = [
            "" if model is None else model.card.name,
            self._metrics.summary(),
            self._loading and f"loading {self._loading}",
        ]
        return "; ".join(part for part in parts if part)

    def configure(self) -> None:
        """Load the model, warm it up, serve. Raises ConfigError or ModelError."""
        config = self._config.model_config()
        model = load_model(self._load, config, self._config.point_rule, self._clock.now_ns)
        self._model = model
        self._queue.start()
        # Handlers only wait for the queue: enough of them to fill it, and one more to say no.
        self._bus.serve(topics.GROUND, self._ground, workers=self._config.queue_limit + 2)
        self._bus.serve(topics.USE_MODEL, self._use, workers=2)
        _LOG.info(
            "model loaded", extra={"model": model.card.name, "threshold": model.card.threshold}
        )

    def run(self, stop: threading.Event) -> None:
        """Wait: the bus's threads and the queue's do the work.

        Raises:
            ModelError: the GPU failed. Who started this process starts it anew.
        """
        while not stop.wait(LOOK_PERIOD_S):
            if self._lost:
                raise ModelError(
                    f"the vision model's device {self._config.device} failed: {self._lost}; this "
                    "process cannot use it any more and must be started anew"
                )

    def close(self) -> None:
        """Finish the answer that is being made, refuse the rest, let go of the model."""
        self._queue.close()
        model, self._model = self._model, None
        if model is not None:
            model.close()

    def _ground(self, request: GroundingRequest, context: CallContext) -> GroundingReply:
        try:
            answered = self._queue.ask(request)
        except W2CError as error:
            self._bus.count(_CAUSES.get(error.code, error.code))
            raise
        reply = answered.reply
        self._metrics.answered(answered.queue_ms, answered.together)
        _LOG.info(
            "grounded",
            extra={
                "caller": context.caller,
                "model": reply.model,
                "phrases": len(request.phrases),
                "found": sum(one.found for one in reply.evidence),
                "milliseconds": round(reply.milliseconds),
                "queue_ms": round(answered.queue_ms),
                "together": answered.together,
            },
        )
        return reply

    def _answer(self, requests: list[GroundingRequest]) -> list[GroundingReply]:
        """Answer requests about one picture; on the queue's thread."""
        model = self._model
        if model is None:
            raise UnavailableError("grounding is shutting down; ask another replica")
        dropped = model.grounder.dropped_boxes
        try:
            return ground_together(model.grounder, requests)
        except RuntimeError as error:
            if is_device_lost(error):
                self._lost = str(error)
            raise
        finally:
            self._metrics.worked(model.family.take())
            if model.grounder.dropped_boxes > dropped:
                self._bus.count("answers with boxes that make no sense")

    def _use(self, request: UseModelRequest, context: CallContext) -> UseModelReply:
        """Load another model beside the one that answers; then it takes over.

        Raises:
            RefusedError: another one is being loaded, or this one cannot be.
        """
        if not self._changing.acquire(blocking=False):
            raise RefusedError(f"{self._loading} is being loaded; ask again when it is there")
        try:
            self._loading = request.model
            return self._change(request, context)
        finally:
            self._loading = ""
            self._changing.release()

    def _change(self, request: UseModelRequest, context: CallContext) -> UseModelReply:
        started = self._clock.now_ns()
        config = another(self._config.model_config(), request.model, request.family)
        model = load_model(self._load, config, self._config.point_rule, self._clock.now_ns)
        seconds = (self._clock.now_ns() - started) * 1e-9
        try:
            previous = self._let_take_over(model)
        except UnavailableError:
            model.close()
            raise
        give_memory_back(config.device)
        _LOG.info(
            "model changed",
            extra={
                "caller": context.caller,
                "model": model.card.name,
                "previous": previous,
                "seconds": round(seconds, 1),
            },
        )
        return UseModelReply(
            model=model.card.name,
            previous=previous,
            threshold=model.card.threshold,
            seconds=seconds,
            memory_mb=psutil.Process().memory_info().rss / 1e6,
        )

    def _let_take_over(self, model: LoadedModel) -> str:
        """Put the model in the place of the other between two requests; return the other's name."""

        def take_over() -> LoadedModel | None:
            old, self._model = self._model, model
            return old

        old = self._queue.between(take_over)
        if old is None:
            return ""
        old.close()
        return old.card.name
