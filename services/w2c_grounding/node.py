"""Grounding on the bus: serves `grounding/ground`."""

import logging
import threading

import numpy as np

from w2c import topics
from w2c.bus import Bus, CallContext
from w2c.clock import Clock
from w2c.errors import UnavailableError
from w2c.messages import GroundingReply, GroundingRequest
from w2c_grounding.answer import Grounder
from w2c_grounding.config import Config
from w2c_grounding.gate import Gate
from w2c_grounding.picture import encode_png
from w2c_grounding.registry import load

_LOG = logging.getLogger("w2c.grounding")


class GroundingNode:
    """One replica. Stateless: what it remembers of pictures only saves time."""

    def __init__(self, config: Config, bus: Bus, clock: Clock) -> None:
        self._config = config
        self._bus = bus
        self._clock = clock
        self._gate = Gate(config.queue_limit)
        self._grounder: Grounder | None = None

    def configure(self) -> None:
        """Load the model, warm it up, serve. Raises ConfigError or ModelError."""
        family, card = load(self._config.model_config())
        self._grounder = Grounder(family, card, self._config.point_rule, self._clock.now_ns)
        self._warm_up(self._grounder)
        # One thread answers, `queue_limit` wait at the gate, and one more is left to say no.
        self._bus.serve(topics.GROUND, self._ground, workers=self._config.queue_limit + 2)
        _LOG.info("model loaded", extra={"model": card.name, "threshold": card.threshold})

    def run(self, stop: threading.Event) -> None:
        """Wait: the bus's threads do the work."""
        stop.wait()

    def close(self) -> None:
        """Let go of the model."""
        self._grounder = None

    def _ground(self, request: GroundingRequest, context: CallContext) -> GroundingReply:
        with self._gate.turn():
            grounder = self._grounder
            if grounder is None:
                raise UnavailableError("grounding is shutting down; ask another replica")
            reply = grounder.ground(request)
        _LOG.info(
            "grounded",
            extra={
                "caller": context.caller,
                "phrases": len(request.phrases),
                "found": sum(one.found for one in reply.evidence),
                "milliseconds": round(reply.milliseconds),
                # Of all requests so far: a model that keeps giving boxes of NaN shows here.
                "dropped_boxes": grounder.dropped_boxes,
            },
        )
        return reply

    def _warm_up(self, grounder: Grounder) -> None:
        """Answer once: the first answer chooses kernels, and takes several times longer."""
        blank = encode_png(np.full((720, 1280, 3), 128, dtype=np.uint8))
        grounder.ground(GroundingRequest(jpeg=blank, phrases=["warm up"], want="heatmaps"))
