"""The model services of the product in this process, each on a bus of its own, asked once.

What was asked before is remembered: twelve combinations share three language models and four
vision models, and every repetition looks at the same pictures.
"""

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any, Literal, Protocol

import msgspec

from w2c import topics
from w2c.bus import Bus, InProcessHub
from w2c.clock import RealClock
from w2c.config import load
from w2c.library import library
from w2c.messages import (
    ChooseRequest,
    CompleteRequest,
    GroundingRequest,
    PhraseEvidence,
)
from w2c_evaluation.prediction.combinations import ModelSpec

PATIENCE_S = 600.0
"""For one answer: nobody waits here, and large models on a CPU are slow"""
PLACES = {"language_service": "llm", "grounding_service": "grounding"}


@dataclass(frozen=True)
class Chosen:
    """The answer to a question with options."""

    option: str
    probabilities: dict[str, float]


@contextmanager
def service(
    kind: Literal["language_service", "grounding_service"], spec: ModelSpec
) -> Iterator[Bus]:
    """Yield a bus on which a model answers.

    Raises:
        ConfigError: its flags make no sense.
        W2CError: the model cannot be loaded.
    """
    hub = InProcessHub()
    with ExitStack() as stack:
        flags: dict[str, Any] = dict(spec.flags)
        if kind == "language_service":
            flags.setdefault("deadline", PATIENCE_S)
        chosen: Any = load(library(f"{kind}_config"), {"robot": "test", **flags})
        bus = hub.connect(PLACES[kind])
        stack.callback(bus.close)
        node = library(kind)(chosen, bus, RealClock())
        stack.callback(node.close)
        node.configure()
        asking = hub.connect("evaluation")
        stack.callback(asking.close)
        yield asking


class Language:
    """One language model, as the dialogue's modules ask it."""

    def __init__(self, bus: Bus, *, temperature: float) -> None:
        self._bus = bus
        self._temperature = temperature
        self._known: dict[bytes, Any] = {}
        self.seed = 0
        """Of the answers from now on; without a temperature it changes none"""
        self.language_model = ""
        """Name of the model that answered last"""

    def complete(self, question: Any) -> Any:
        """Return the decoded JSON that answers a question."""
        request = CompleteRequest(
            messages=list(question.messages),
            schema=question.schema or {},
            seed=self.seed if self._temperature > 0.0 else 0,
            temperature=self._temperature,
            constant_messages=question.constant_messages,
            deadline=PATIENCE_S,
        )
        key = _digest(request)
        if key not in self._known:
            reply = self._bus.call(topics.COMPLETE, request, timeout_s=PATIENCE_S).message
            self.language_model = reply.model
            self._known[key] = reply.value
        return self._known[key]

    def choose(self, question: Any, log_prior: Mapping[str, float]) -> Chosen:
        """Return the most probable of the question's options."""
        request = ChooseRequest(
            messages=list(question.messages),
            options=list(question.options),
            log_prior=dict(log_prior),
            constant_messages=question.constant_messages,
            deadline=PATIENCE_S,
        )
        key = _digest(request)
        if key not in self._known:
            reply = self._bus.call(topics.CHOOSE, request, timeout_s=PATIENCE_S).message
            self.language_model = reply.model
            self._known[key] = Chosen(reply.option, reply.probabilities)
        chosen: Chosen = self._known[key]
        return chosen


class Vision:
    """One vision model; remembers what it saw of each picture."""

    def __init__(self, bus: Bus) -> None:
        self._bus = bus
        self._known: dict[bytes, list[PhraseEvidence]] = {}
        self.name = ""
        """Of the model that looked last"""

    def ground(self, picture: bytes, phrases: Sequence[str], want: str) -> list[PhraseEvidence]:
        """Return what is seen of each phrase."""
        request = GroundingRequest(
            jpeg=picture,
            phrases=list(phrases),
            want="heatmaps" if want == "heatmaps" else "boxes",
        )
        key = _digest(request)
        if key not in self._known:
            reply = self._bus.call(topics.GROUND, request, timeout_s=PATIENCE_S).message
            self.name = reply.model
            self._known[key] = reply.evidence
        return self._known[key]


class Eye(Protocol):
    """Anything that finds phrases in pictures."""

    name: str

    def ground(self, picture: bytes, phrases: Sequence[str], want: str) -> list[PhraseEvidence]:
        """Return what is seen of each phrase."""


class Eyes:
    """A detector for boxes and a segmenter for heatmaps, as the dialogue's modules ask them."""

    def __init__(self, detector: Eye, segmenter: Eye) -> None:
        self._detector = detector
        self._segmenter = segmenter

    @property
    def vision_model(self) -> str:
        """Return the names of both."""
        return " + ".join(dict.fromkeys((self._detector.name, self._segmenter.name)))

    def ground(
        self, frame: Any, phrases: Sequence[str], want: Literal["heatmaps", "boxes"]
    ) -> list[PhraseEvidence]:
        """Return what the model for this kind of evidence sees of each phrase."""
        model = self._segmenter if want == "heatmaps" else self._detector
        return model.ground(frame.jpeg, phrases, want)


def _digest(request: Any) -> bytes:
    return hashlib.blake2b(msgspec.msgpack.encode(request), digest_size=16).digest()
