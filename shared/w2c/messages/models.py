"""Messages of the stateless model services: llm and grounding.

A request carries everything, so that any replica can answer and any recorded request can be asked
again.
"""

from typing import Annotated, Any, Literal

import msgspec
import numpy as np

from w2c.messages.base import Array, Message, Name, Text, check_array


class ChatMessage(Message, frozen=True, kw_only=True):
    """One message of a chat."""

    role: Literal["system", "user", "assistant"]
    content: Text


Patience = Annotated[float, msgspec.Meta(gt=0, le=600)]


class CompleteRequest(Message, frozen=True, kw_only=True):
    """Complete a chat with JSON that fits a schema."""

    messages: Annotated[list[ChatMessage], msgspec.Meta(min_length=1, max_length=100)]
    schema: dict[str, Any]
    """JSON schema of the answer; strings must be bounded by maxLength, enum or pattern."""
    seed: int = 0
    temperature: float = 0.0
    max_tokens: Annotated[int, msgspec.Meta(gt=0, le=4096)] = 400
    constant_messages: int = 0
    """How many leading messages are the same in every request of this kind (prompt and examples):
    a hint for reuse, never needed for the answer."""
    deadline: Patience | None = None
    """How long the caller waits [s]; then the work is given up. None = as long as the service
    allows."""


class CompleteReply(Message, frozen=True, kw_only=True):
    """The answer: `value` fits the schema of the request."""

    text: Text
    value: Any
    model: Name
    prompt_tokens: int
    reused_tokens: int
    """Of the prompt, found evaluated already"""
    completion_tokens: int
    queue_ms: float
    prefill_ms: float
    decode_ms: float


class ChooseRequest(Message, frozen=True, kw_only=True):
    """Which of the options follows the chat, with the probability of each."""

    messages: Annotated[list[ChatMessage], msgspec.Meta(min_length=1, max_length=100)]
    options: Annotated[list[Name], msgspec.Meta(min_length=2, max_length=32)]
    log_prior: dict[str, float] = {}
    """Added to the log-likelihood of an option: the paper's logit bias."""
    constant_messages: int = 0
    deadline: Patience | None = None
    """As of `complete` [s]."""


class ChooseReply(Message, frozen=True, kw_only=True):
    """`option` has the highest probability."""

    option: Name
    probabilities: dict[str, float]
    model: Name
    prompt_tokens: int
    reused_tokens: int
    queue_ms: float
    prefill_ms: float


class GroundingRequest(Message, frozen=True, kw_only=True):
    """Find phrases in a picture."""

    jpeg: Annotated[bytes, msgspec.Meta(min_length=1, max_length=20_000_000)]
    phrases: Annotated[list[Name], msgspec.Meta(min_length=1, max_length=32)]
    want: Literal["heatmaps", "boxes"]


class Box(Message, frozen=True, kw_only=True):
    """A box in pixels of the picture; (left, top) inclusive, (right, bottom) exclusive."""

    left: float
    top: float
    right: float
    bottom: float
    score: float


class PhraseEvidence(Message, frozen=True, kw_only=True):
    """What was found for one phrase; best box first, empty where nothing was found."""

    phrase: Name
    found: bool
    score: float
    point: tuple[float, float] | None
    """Where to touch it (u, v) [px]; None where nothing was found"""
    boxes: list[Box]
    heatmap: Array | None = None
    """(h, w) uint8, 255 = certain; covers the whole picture at a lower resolution"""
    unknown_words: list[str] = []
    """Words of the phrase the model has never seen"""

    def __post_init__(self) -> None:
        """Refuse a heatmap that is none."""
        if self.heatmap is not None:
            check_array("heatmap", self.heatmap, (None, None), dtype=np.uint8)


class GroundingReply(Message, frozen=True, kw_only=True):
    """Evidence for each phrase of the request, in its order."""

    model: Name
    width: int
    height: int
    evidence: list[PhraseEvidence]
    milliseconds: float


class UseModelRequest(Message, frozen=True, kw_only=True):
    """Answer with another vision model from now on."""

    model: Annotated[str, msgspec.Meta(min_length=1, max_length=1000)]
    """As the grounding process's `--model` takes it, on its machine; `embedded` = the model of
    this repository"""
    family: Annotated[str, msgspec.Meta(max_length=100)] = ""
    """Empty = what the checkpoint says of itself"""


class UseModelReply(Message, frozen=True, kw_only=True):
    """The model answers; requests that came meanwhile were answered by the one before."""

    model: Name
    previous: Text
    """Name of the model before; "" where there was none"""
    threshold: float
    """A phrase whose score is below it is not in the picture"""
    seconds: float
    """What loading took"""
    memory_mb: float
    """Of the process, after the model before was let go"""
