"""The fields of OpenAI's chat completions that are used."""

import msgspec


class Content(msgspec.Struct):
    """What the model said."""

    content: str | None = None


class TopToken(msgspec.Struct):
    """A token that could stand at a position."""

    token: str
    logprob: float


class Position(msgspec.Struct):
    """One position of the answer."""

    top_logprobs: list[TopToken] = []


class Logprobs(msgspec.Struct):
    """How likely the tokens of the answer were."""

    content: list[Position] | None = None


class ReplyChoice(msgspec.Struct):
    """One of the answers; only one is asked for."""

    message: Content
    finish_reason: str | None = None
    logprobs: Logprobs | None = None


class Cached(msgspec.Struct):
    """What the server had evaluated already."""

    cached_tokens: int | None = 0


class TokenCounts(msgspec.Struct):
    """What the answer cost."""

    prompt_tokens: int = 0
    completion_tokens: int = 0
    prompt_tokens_details: Cached | None = None


class Reply(msgspec.Struct):
    """The fields of a chat completion that are used; the rest is ignored."""

    choices: list[ReplyChoice]
    usage: TokenCounts | None = None
