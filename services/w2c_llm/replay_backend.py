"""Answers from a recording: the model of yesterday, without the model.

The bus traces every call with request and reply, and the recorder keeps the traces. A request that
asks the same again (messages, schema and sampling; who asked, and what was reused, does not count)
gets the answer that it got then, the first one where it was asked several times: a service keeps
no state, so the same request always gets the same answer.
"""

import hashlib
import logging
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import msgspec

from w2c import topics
from w2c.bus import decode_envelope
from w2c.bus.codec import validate
from w2c.errors import ConfigError, MessageError, RecordingError, RefusedError
from w2c.extras import needs_extra
from w2c.library import library
from w2c.messages import (
    CallTrace,
    ChatMessage,
    ChooseReply,
    ChooseRequest,
    CompleteReply,
    CompleteRequest,
    Message,
)
from w2c_llm.backend import (
    Budget,
    Capabilities,
    Generation,
    JsonSchema,
    Sampling,
    Scores,
    Usage,
)
from w2c_llm.schema import check_schema

_LOG = logging.getLogger("w2c.llm.replay")
M = TypeVar("M", bound=Message)
_LEAST_PROBABILITY = 1e-300
"""Stands for an option that had none: its logarithm is finite"""


@dataclass(frozen=True)
class _Likelihoods:
    """What a choice says of its options, without the prior that it was asked with."""

    logarithms: dict[str, float]
    usage: Usage


class ReplayBackend:
    """A model that knows only what was asked before. Thread-safe: it is only read."""

    def __init__(self, path: Path) -> None:
        """Read the calls of the language service from a recording.

        Raises:
            ConfigError: there is no such file, it is no recording, or it holds no answer.
        """
        self._path = path
        self._model = ""
        self._generations: dict[str, Generation] = {}
        self._scores: dict[str, _Likelihoods] = {}
        unreadable = 0
        for trace in _traces(path):
            try:
                self._learn(trace)
            except (MessageError, RefusedError):  # of another version of the messages
                unreadable += 1
        if unreadable:
            _LOG.warning("recorded calls not read", extra={"calls": unreadable, "file": str(path)})
        if not self._generations and not self._scores:
            raise ConfigError(
                f"{path} holds no answer of a language model; record a conversation, and give its "
                "session.mcap with --model"
            )

    @property
    def name(self) -> str:
        """Name of the model that was recorded."""
        return f"replay of {self._model}"[:100]

    @property
    def capabilities(self) -> Capabilities:
        """Answers were checked when they were recorded; they cost nothing now."""
        return Capabilities(
            constrained=True, likelihoods=True, seed=True, prefix_reuse=False, concurrent_calls=1
        )

    def warm_up(self) -> None:
        """Do nothing: all was read at the start."""

    def close(self) -> None:
        """Forget the recording. Idempotent."""
        self._generations.clear()
        self._scores.clear()

    def generate(
        self,
        messages: Sequence[ChatMessage],
        schema: JsonSchema,
        sampling: Sampling,
        constant_messages: int,  # noqa: ARG002 - a hint, not part of the question
        budget: Budget,
    ) -> Generation:
        """Return what was answered then. Raises RefusedError for a request that was not asked."""
        budget.check()
        found = self._generations.get(_key(messages, schema, msgspec.to_builtins(sampling)))
        if found is None:
            raise self._unknown("complete", messages)
        return found

    def score(
        self,
        messages: Sequence[ChatMessage],
        options: Sequence[str],
        constant_messages: int,  # noqa: ARG002 - as above
        budget: Budget,
    ) -> Scores:
        """Return how likely each option was then. Raises RefusedError as `generate` does."""
        budget.check()
        found = self._scores.get(_key(messages, sorted(options)))
        if found is None:
            raise self._unknown("choose", messages)
        return Scores([found.logarithms[option] for option in options], found.usage)

    def _unknown(self, method: str, messages: Sequence[ChatMessage]) -> RefusedError:
        return RefusedError(
            f"{self._path} has no answer to this `{method}` request, which ends with "
            f"'{messages[-1].content[-80:]}': it was not asked in that recording with the same "
            "prompts, schema and seed. Use another recording, or a model"
        )

    def _learn(self, trace: CallTrace) -> None:
        """Keep one answered call; a later one never replaces it."""
        if trace.method == topics.COMPLETE.name:
            self._learn_completion(
                _content(trace.request, CompleteRequest), _content(trace.reply, CompleteReply)
            )
        elif trace.method == topics.CHOOSE.name:
            self._learn_choice(
                _content(trace.request, ChooseRequest), _content(trace.reply, ChooseReply)
            )

    def _learn_completion(self, request: CompleteRequest, reply: CompleteReply) -> None:
        sampling = Sampling(request.temperature, request.seed, request.max_tokens)
        schema = check_schema(request.schema)
        usage = Usage(
            prompt_tokens=reply.prompt_tokens,
            reused_tokens=reply.reused_tokens,
            completion_tokens=reply.completion_tokens,
        )
        self._model = self._model or reply.model
        key = _key(request.messages, schema, msgspec.to_builtins(sampling))
        self._generations.setdefault(key, Generation(reply.text, True, usage))

    def _learn_choice(self, request: ChooseRequest, reply: ChooseReply) -> None:
        logarithms = {
            option: math.log(max(probability, _LEAST_PROBABILITY))
            - request.log_prior.get(option, 0.0)
            for option, probability in reply.probabilities.items()
        }
        usage = Usage(prompt_tokens=reply.prompt_tokens, reused_tokens=reply.reused_tokens)
        self._model = self._model or reply.model
        key = _key(request.messages, sorted(request.options))
        self._scores.setdefault(key, _Likelihoods(logarithms, usage))


def _key(messages: Sequence[ChatMessage], *rest: object) -> str:
    """Return the hash of what makes a request what it is; the order of properties counts."""
    chat = [(message.role, message.content) for message in messages]
    return hashlib.sha256(msgspec.json.encode([chat, *rest])).hexdigest()


def _traces(path: Path) -> Iterator[CallTrace]:
    """Yield the calls of the language service that were answered."""
    if not path.is_file():
        raise ConfigError(f"no recording at {path}; give a session.mcap with --model")
    with needs_extra("recorder"):
        recording = library("recording")(path)
    try:
        for recorded in recording.of(topics.TRACE):
            trace = recorded.message
            if (trace.service, trace.outcome) == (topics.COMPLETE.service, "ok"):
                yield trace
    except RecordingError as error:
        raise ConfigError(f"--model for replay: {error}") from error


def _content(payload: bytes, message_type: type[M]) -> M:
    return validate(decode_envelope(payload).data, message_type)
