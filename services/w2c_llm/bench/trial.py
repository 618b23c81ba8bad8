"""The same questions, asked here and with llama-cpp-python alone: time, tokens, answers.

Plain is what its documentation shows: one `Llama`, `create_chat_completion` with a grammar,
temperature 0. It keeps what the last prompt and the next one begin with alike, which is nothing
when the kinds of question alternate.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import llama_cpp
import numpy as np
from llama_cpp.llama_grammar import LlamaGrammar

from w2c.clock import RealClock
from w2c.errors import ConfigError
from w2c.messages import ChatMessage, CompleteRequest
from w2c_llm.answering import complete
from w2c_llm.backend import Budget
from w2c_llm.bench.questions import KINDS, Kind, prefix_of, question, utterances
from w2c_llm.gbnf import grammar_of
from w2c_llm.llama_cpp_backend import LlamaCppBackend
from w2c_llm.llama_model import is_built_for_amx
from w2c_llm.schema import check_schema

Clock = Callable[[], float]
CONTEXT = 4096
"""For us: five prefixes and the request"""
PLAIN_CONTEXT = 1024
"""For plain: one prompt and its answer"""
_PATIENCE_S = 600.0


@dataclass(frozen=True)
class Cost:
    """Of one question, one way."""

    milliseconds: float
    prompt_tokens: int
    """Of the prompt, evaluated now"""
    answer_tokens: int
    """Evaluated while the answer was written"""
    text: str


@dataclass(frozen=True)
class Pair:
    """One question, both ways."""

    case: str
    plain: Cost
    ours: Cost


@dataclass(frozen=True)
class Comparison:
    """All questions to one model."""

    model: str
    pairs: list[Pair]
    first: list[Cost]
    """Ours, of the first question of each kind: it evaluates the prefix"""


class PlainModel:
    """llama-cpp-python's high-level interface."""

    def __init__(self, path: Path, threads: int) -> None:
        """Load a file. Raises ConfigError where plain calls would end the process."""
        if is_built_for_amx():
            raise ConfigError(
                "this llama.cpp was built for AMX, with which plain calls end the process; "
                "remove .wheels and .venv and run `make setup`, which builds it without"
            )
        self._llama = llama_cpp.Llama(
            str(path),
            n_ctx=PLAIN_CONTEXT,
            n_threads=threads,
            n_threads_batch=threads,
            verbose=False,
        )
        self._grammars: dict[str, LlamaGrammar] = {}

    def ask(self, request: CompleteRequest, clock: Clock) -> Cost:
        """Answer a question; its grammar is made outside of the time."""
        text = grammar_of(check_schema(request.schema))
        if text not in self._grammars:
            self._grammars[text] = LlamaGrammar.from_string(text, verbose=False)
        context = self._llama._ctx.ctx  # no public name
        llama_cpp.llama_perf_context_reset(context)
        messages: Any = [{"role": m.role, "content": m.content} for m in request.messages]
        started = clock()
        reply: Any = self._llama.create_chat_completion(
            messages,
            grammar=self._grammars[text],
            temperature=0.0,
            max_tokens=request.max_tokens,
        )
        elapsed = clock() - started
        counted = llama_cpp.llama_perf_context(context)
        # llama.cpp counts tokens that are evaluated one by one as the answer's.
        return Cost(
            1e3 * elapsed,
            int(counted.n_p_eval),
            int(counted.n_eval),
            str(reply["choices"][0]["message"]["content"]),
        )

    def close(self) -> None:
        """Free the model."""
        self._llama.close()


def compare(
    path: Path,
    *,
    rounds: int,
    threads: int,
    seed: int,
    kinds: Sequence[Kind] = KINDS,
    prefix_tokens: int = 600,
) -> Comparison:
    """Ask each kind in turn, `rounds` times, both ways with the same model.

    Args:
        path: A GGUF file.
        rounds: Questions of each kind, after one that gives us its prefix.
        threads: Of both. With one, times are CPU time of the thread, which does not count what
            else the machine does; with more, wall time.
        seed: Of the sentences.
        kinds: What is asked.
        prefix_tokens: Of the constant messages, counted by the model that is measured.

    Raises:
        ConfigError: there is no such file.
        ModelError: it cannot be loaded.
    """
    clock = time.thread_time if threads == 1 else time.perf_counter
    rng = np.random.default_rng(seed)
    backend = LlamaCppBackend(path, context=CONTEXT, threads=threads)
    plain = PlainModel(path, threads)
    try:
        sentences = utterances(rng)
        prefixes = {
            kind.name: prefix_of(kind, prefix_tokens, backend.count_tokens, rng) for kind in kinds
        }
        backend.warm_up()
        plain.ask(question(kinds[0], _SHORT, "yes"), clock)
        first = [
            ask_ours(backend, question(kind, prefixes[kind.name], next(sentences)), clock)
            for kind in kinds
        ]
        pairs = []
        for kind in list(kinds) * rounds:
            asked = question(kind, prefixes[kind.name], next(sentences))
            ours = ask_ours(backend, asked, clock)
            pairs.append(Pair(kind.name, plain.ask(asked, clock), ours))
        return Comparison(backend.name, pairs, first)
    finally:
        backend.close()
        plain.close()


def ask_ours(backend: LlamaCppBackend, request: CompleteRequest, clock: Clock) -> Cost:
    """Answer a question as the service does: schema checked, answer validated."""
    before = backend.evaluated_tokens
    started = clock()
    answer = complete(backend, request, Budget(RealClock(), _PATIENCE_S))
    elapsed = clock() - started
    evaluated = backend.evaluated_tokens - before
    prompt = answer.usage.prompt_tokens - answer.usage.reused_tokens
    return Cost(1e3 * elapsed, prompt, evaluated - prompt, answer.text)


_SHORT = [ChatMessage(role="system", content="Say yes.")]
