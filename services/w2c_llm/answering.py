"""From a request to a checked answer: parse, validate, repair once, give up with a reason."""

import json
import math
from dataclasses import dataclass
from typing import Any

from w2c.errors import ModelError, RefusedError
from w2c.messages import ChatMessage, ChooseRequest, CompleteRequest
from w2c_llm.backend import Backend, Budget, Generation, JsonSchema, Sampling, Usage
from w2c_llm.schema import check_schema
from w2c_llm.values import violation

_MAX_ANSWER_CHARACTERS = 20_000
MAX_TEMPERATURE = 10.0
_SEEDS = 2**63


@dataclass(frozen=True)
class Completion:
    """A checked answer."""

    text: str
    value: Any
    usage: Usage


@dataclass(frozen=True)
class Choice:
    """The most probable option, and the probability of each."""

    option: str
    probabilities: dict[str, float]
    usage: Usage


def complete(backend: Backend, request: CompleteRequest, budget: Budget) -> Completion:
    """Answer with a value that fits the schema.

    Raises:
        RefusedError: the schema or the chat cannot be served.
        DeadlineError: the budget is spent.
        ModelError: two answers in a row did not fit; the message says why.
    """
    check_chat(request.messages, request.constant_messages)
    schema = check_schema(request.schema)
    sampling = check_sampling(request)
    first = backend.generate(request.messages, schema, sampling, request.constant_messages, budget)
    value, reason = read_answer(first, schema)
    if reason is None:
        return Completion(first.text, value, first.usage)
    second = backend.generate(
        _repair_chat(request.messages, first.text, reason),
        schema,
        sampling,
        request.constant_messages,
        budget,
    )
    value, still = read_answer(second, schema)
    if still is None:
        return Completion(second.text, value, first.usage + second.usage)
    raise ModelError(
        f"{backend.name} answered outside its schema twice: {reason}; then {still}. "
        "Use a larger model, more max_tokens or a simpler schema"
    )


def check_sampling(request: CompleteRequest) -> Sampling:
    """Return how to sample. Raises RefusedError for a temperature or a seed that is none."""
    if not 0.0 <= request.temperature <= MAX_TEMPERATURE:
        raise RefusedError(
            f"temperature is {request.temperature}, must be 0 to {MAX_TEMPERATURE:g}"
        )
    if not 0 <= request.seed < _SEEDS:
        raise RefusedError(f"seed is {request.seed}, must be 0 to {_SEEDS - 1}")
    return Sampling(request.temperature, request.seed, request.max_tokens)


def read_answer(generation: Generation, schema: JsonSchema) -> tuple[Any, str | None]:
    """Return (value, None), or (None, why the text is not an answer)."""
    if len(generation.text) > _MAX_ANSWER_CHARACTERS:
        return None, f"{len(generation.text)} characters, limit {_MAX_ANSWER_CHARACTERS}"
    try:
        value = json.loads(generation.text, parse_constant=_refuse_constant)
        json.dumps(value, ensure_ascii=False).encode()  # half a character cannot be sent
    except (ValueError, RecursionError) as error:
        cut = "" if generation.complete else "cut off at the limit of tokens, "
        return None, f"{cut}not JSON ({error})"
    reason = violation(value, schema)
    return (value, None) if reason is None else (None, reason)


def _refuse_constant(name: str) -> float:
    raise ValueError(f"{name} is not JSON")


def _repair_chat(messages: list[ChatMessage], text: str, reason: str) -> list[ChatMessage]:
    """Return the chat that shows the model its answer and what is wrong with it."""
    complaint = (
        f"That answer does not fit: {reason[:500]}. Answer again, with the JSON object only."
    )
    return [
        *messages,
        ChatMessage(role="assistant", content=text[:2000] or "(nothing)"),
        ChatMessage(role="user", content=complaint),
    ]


def choose(backend: Backend, request: ChooseRequest, budget: Budget) -> Choice:
    """Return the option of highest posterior: likelihood times prior, normalised over the options.

    Raises:
        RefusedError: the options repeat, or a prior is unknown or not finite.
        DeadlineError, ModelError: as for `complete`.
    """
    check_chat(request.messages, request.constant_messages)
    if len(set(request.options)) < len(request.options):
        raise RefusedError(f"options repeat: {request.options}")
    for option, prior in request.log_prior.items():
        if option not in request.options or not math.isfinite(prior):
            raise RefusedError(
                f"log_prior {prior} of '{option}': must be finite, for one of {request.options}"
            )
    scores = backend.score(request.messages, request.options, request.constant_messages, budget)
    weighted = [
        likelihood + request.log_prior.get(option, 0.0)
        for option, likelihood in zip(request.options, scores.log_likelihoods, strict=True)
    ]
    probabilities = dict(zip(request.options, softmax(weighted), strict=True))
    best = max(probabilities, key=lambda option: probabilities[option])
    return Choice(best, probabilities, scores.usage)


def softmax(logarithms: list[float]) -> list[float]:
    """Return exp(x) / sum exp(x). Raises ModelError where no option is possible."""
    highest = max(logarithms)
    if not math.isfinite(highest):
        raise ModelError(f"no option has a likelihood: {logarithms}")
    weights = [math.exp(value - highest) for value in logarithms]
    total = sum(weights)
    return [weight / total for weight in weights]


def check_chat(messages: list[ChatMessage], constant_messages: int) -> None:
    """Raise RefusedError unless the chat ends with the user and the hint fits it."""
    if messages[-1].role != "user":
        raise RefusedError(f"the last message is of the {messages[-1].role}, must be of the user")
    if not 0 <= constant_messages < len(messages):
        raise RefusedError(
            f"constant_messages is {constant_messages}, must be 0 to {len(messages) - 1}: "
            "the last message is never constant"
        )
