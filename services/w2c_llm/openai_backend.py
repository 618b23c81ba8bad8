"""Any server with OpenAI's chat completions: llama-server, vLLM, Ollama, or one in the cloud."""

import json
import math
import re
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import msgspec

from w2c.chat_server import ChatServer, extract_json
from w2c.errors import ModelError
from w2c.messages import ChatMessage
from w2c_llm.backend import Budget, Capabilities, Generation, JsonSchema, Sampling, Scores, Usage
from w2c_llm.gbnf import grammar_of
from w2c_llm.openai_wire import Reply, ReplyChoice, TokenCounts
from w2c_llm.schema import MAX_PATTERN

_IMPOSSIBLE = -30.0
"""Log-likelihood of an option that is not among the likely tokens which the server lists"""


@dataclass(frozen=True)
class OpenAiOptions:
    """What to ask whom, and what the server understands: a model's name does not tell."""

    url: str
    model: str
    schema_mode: Literal["json_schema", "json_object", "gbnf", "none"] = "json_schema"
    sampling: bool = True
    token_limit: Literal["max_tokens", "max_completion_tokens"] = "max_tokens"  # noqa: S105
    logprobs: bool = False
    concurrency: int = 4


class OpenAiBackend:
    """A client of one server. Thread-safe."""

    def __init__(
        self,
        options: OpenAiOptions,
        key: str,
        *,
        pause: Callable[[float], None] | None = None,
    ) -> None:
        """Prepare a client; nothing is sent before the first request.

        Args:
            options: The server and what it understands.
            key: Sent as bearer token; empty: none is sent. Kept out of logs and errors.
            pause: Waits some seconds between attempts; tests pass their own.

        Raises:
            ConfigError: the address of the server is none.
        """
        self._options = options
        self._server = ChatServer(
            options.url,
            key,
            flag="--openai-",
            other_flags="--model, --openai-url, --openai-schema and --openai-sampling",
            pause=pause,
        )

    @property
    def name(self) -> str:
        """Name of the model at the server."""
        return self._options.model[:100]

    @property
    def capabilities(self) -> Capabilities:
        """What it promises: less than a model in this process."""
        return Capabilities(
            constrained=False,
            likelihoods=self._options.logprobs,
            seed=False,
            prefix_reuse=False,
            concurrent_calls=self._options.concurrency,
        )

    def warm_up(self) -> None:
        """Do nothing: a request would cost money, and the server may come later."""

    def close(self) -> None:
        """Close the connections. Idempotent."""
        self._server.close()

    def generate(
        self,
        messages: Sequence[ChatMessage],
        schema: JsonSchema,
        sampling: Sampling,
        constant_messages: int,  # noqa: ARG002 - servers find common prefixes themselves
        budget: Budget,
    ) -> Generation:
        """Ask for JSON of a schema. Prose around it is cut off; the caller validates the rest."""
        named = described(schema)
        instruction = (
            "Answer with one JSON value and nothing else, in this JSON schema: "
            + json.dumps(named, ensure_ascii=False)
        )
        chat = [_as_dict(message) for message in messages]
        chat[-1]["content"] += "\n\n" + instruction
        body: dict[str, Any] = {"messages": chat, self._options.token_limit: sampling.max_tokens}
        if self._options.sampling:
            body.update(temperature=sampling.temperature, seed=sampling.seed)
        body.update(self._response_format(schema))
        started = time.monotonic()
        reply = self._post(body, budget)
        choice = reply.choices[0]
        text = extract_json(choice.message.content or "")
        return Generation(
            text, choice.finish_reason != "length", _usage(reply, time.monotonic() - started)
        )

    def score(
        self,
        messages: Sequence[ChatMessage],
        options: Sequence[str],
        constant_messages: int,  # noqa: ARG002 - as above
        budget: Budget,
    ) -> Scores:
        """Ask which option fits, by its letter.

        With logprobs the likelihood of each letter is the server's. Without, the option that the
        model names has likelihood 1 and the others e^-30: a prior then only decides against
        overwhelming odds.
        """
        letters = [chr(ord("A") + index) for index in range(26)] + list("123456")
        listed = "\n".join(
            f"{letter}: {option}" for letter, option in zip(letters, options, strict=False)
        )
        chat = [_as_dict(message) for message in messages]
        chat[-1]["content"] += (
            f"\n\nWhich of these is the answer?\n{listed}\nReply with its letter or number only."
        )
        body: dict[str, Any] = {"messages": chat, self._options.token_limit: 16}
        if self._options.sampling:
            body.update(temperature=0.0, seed=0)
        if self._options.logprobs:
            body.update(logprobs=True, top_logprobs=20)
        started = time.monotonic()
        reply = self._post(body, budget)
        found = self._likelihoods(reply.choices[0], letters[: len(options)])
        return Scores(found, _usage(reply, time.monotonic() - started))

    def _likelihoods(self, choice: ReplyChoice, letters: Sequence[str]) -> list[float]:
        if self._options.logprobs and choice.logprobs and choice.logprobs.content:
            masses = dict.fromkeys(letters, math.exp(_IMPOSSIBLE))
            for candidate in choice.logprobs.content[0].top_logprobs:
                letter = candidate.token.strip().upper()
                if letter in masses:  # " A" and "A" are the same answer
                    masses[letter] += math.exp(min(candidate.logprob, 0.0))
            return [math.log(masses[letter]) for letter in letters]
        text = (choice.message.content or "").strip().upper()
        answer = re.match(r"[^A-Z0-9]*([A-Z0-9])\b", text)
        if answer is None or answer.group(1) not in letters:
            raise ModelError(f"{self.name} named none of {', '.join(letters)}: '{text:.80}'")
        return [0.0 if letter == answer.group(1) else _IMPOSSIBLE for letter in letters]

    def _response_format(self, schema: JsonSchema) -> dict[str, Any]:
        if self._options.schema_mode == "none":
            return {}
        if self._options.schema_mode == "json_object":
            return {"response_format": {"type": "json_object"}}
        if self._options.schema_mode == "gbnf":
            return {"grammar": grammar_of(schema)}
        named = {"name": "answer", "schema": described(schema), "strict": True}
        return {"response_format": {"type": "json_schema", "json_schema": named}}

    def _post(self, body: dict[str, Any], budget: Budget) -> Reply:
        """Send a request, and read the answer. Raises as `ChatServer.complete` does."""
        content = self._server.complete({"model": self._options.model, **body}, budget)
        try:
            reply = msgspec.json.decode(content, type=Reply)
        except msgspec.MsgspecError as error:
            raise ModelError(f"{self._options.url} sent no chat completion: {error}") from error
        if not reply.choices:
            raise ModelError(f"{self._options.url} sent a chat completion without choices")
        return reply


def described(schema: Any) -> Any:
    """Return a schema whose long patterns are only told in words: servers refuse such patterns.

    The answer is checked against them all the same.
    """
    if isinstance(schema, list):
        return [described(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    if schema.get("type") == "string" and len(str(schema.get("pattern", ""))) > MAX_PATTERN:
        schema = {name: value for name, value in schema.items() if name != "pattern"}
    return {name: described(value) for name, value in schema.items()}


def _as_dict(message: ChatMessage) -> dict[str, str]:
    return {"role": message.role, "content": message.content}


def _usage(reply: Reply, seconds: float) -> Usage:
    """Return the cost; a server does not tell prefill from decoding."""
    usage = reply.usage or TokenCounts()
    details = usage.prompt_tokens_details
    return Usage(
        prompt_tokens=usage.prompt_tokens,
        reused_tokens=(details.cached_tokens or 0) if details else 0,
        completion_tokens=usage.completion_tokens,
        decode_ms=1e3 * seconds,
    )
