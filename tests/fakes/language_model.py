"""A language model that says what it is told to say."""

import threading
from collections.abc import Sequence

from w2c.messages import ChatMessage
from w2c_llm.backend import (
    Budget,
    Capabilities,
    Generation,
    JsonSchema,
    Sampling,
    Scores,
    Usage,
)

USAGE = Usage(prompt_tokens=10, reused_tokens=4, completion_tokens=3, prefill_ms=1.0, decode_ms=2.0)


class ScriptedBackend:
    """Gives prepared answers in order, and remembers what it was asked and on which thread."""

    def __init__(
        self,
        answers: Sequence[str] = (),
        likelihoods: Sequence[float] = (),
        concurrent_calls: int = 1,
    ) -> None:
        self._answers = list(answers)
        self._likelihoods = list(likelihoods)
        self._concurrent_calls = concurrent_calls
        self.chats: list[list[ChatMessage]] = []
        self.threads: set[int] = {threading.get_ident()}
        self.closed = False

    @property
    def name(self) -> str:
        return "scripted"

    @property
    def capabilities(self) -> Capabilities:
        return Capabilities(
            constrained=False,
            likelihoods=True,
            seed=True,
            prefix_reuse=False,
            concurrent_calls=self._concurrent_calls,
        )

    def warm_up(self) -> None:
        self.threads.add(threading.get_ident())

    def close(self) -> None:
        self.threads.add(threading.get_ident())
        self.closed = True

    def generate(
        self,
        messages: Sequence[ChatMessage],
        schema: JsonSchema,
        sampling: Sampling,
        constant_messages: int,
        budget: Budget,
    ) -> Generation:
        budget.check()
        self.threads.add(threading.get_ident())
        self.chats.append(list(messages))
        return Generation(self._answers.pop(0), True, USAGE)

    def score(
        self,
        messages: Sequence[ChatMessage],
        options: Sequence[str],
        constant_messages: int,
        budget: Budget,
    ) -> Scores:
        budget.check()
        self.threads.add(threading.get_ident())
        self.chats.append(list(messages))
        return Scores(self._likelihoods[: len(options)], USAGE)
