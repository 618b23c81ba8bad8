"""Any GGUF model on this machine, through llama.cpp."""

import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from w2c.errors import ModelError, RefusedError
from w2c.messages import ChatMessage
from w2c_llm.backend import Budget, Capabilities, Generation, JsonSchema, Sampling, Scores, Usage
from w2c_llm.chat_template import ChatTemplate
from w2c_llm.constraint import Constraint, ConstraintKind, make_compiler
from w2c_llm.llama_model import LlamaModel
from w2c_llm.sequences import Logits, Sequences

_LEAST_ANSWER = 8
"""A prompt that leaves fewer tokens than this for the answer is refused"""

_WARM_UP_CHAT = [ChatMessage(role="user", content="Say yes.")]
_WARM_UP_SCHEMA: JsonSchema = {"enum": ["yes"]}


class LlamaCppBackend:
    """One model, one context. Not thread-safe: the engine's thread owns it."""

    def __init__(
        self,
        path: Path,
        *,
        context: int = 4096,
        threads: int = 2,
        gpu_layers: int = 0,
        constraint: ConstraintKind = "llguidance",
    ) -> None:
        """Load a model.

        Args:
            path: A GGUF file with a chat template.
            context: Cells of the key-value cache [tokens], shared by the request and the kept
                prefixes.
            threads: For evaluation.
            gpu_layers: Layers on the GPU; -1 = all.
            constraint: What keeps answers within their schema.

        Raises:
            ConfigError: there is no such file.
            ModelError: it cannot be loaded, or has no chat template.
        """
        self._model = LlamaModel(path, gpu_layers)
        template = self._model.chat_template
        if template is None:
            self._model.close()
            raise ModelError(f"{path} has no chat template; use an instruction-tuned GGUF")
        self._template = ChatTemplate(
            template,
            self._model.begin_text,
            self._model.token_text(self._model.end_of_turn),
            self._model.control_texts,
        )
        self._sequences = Sequences(self._model, context, threads)
        self._compiler = make_compiler(constraint, self._model)
        self._limit = min(self._sequences.cells, self._model.trained_context)

    @property
    def name(self) -> str:
        """Name of the model in its metadata, else of the file."""
        return (self._model.metadata("general.name") or self._model.path.stem)[:100]

    @property
    def capabilities(self) -> Capabilities:
        """What it promises."""
        return Capabilities(
            constrained=True, likelihoods=True, seed=True, prefix_reuse=True, concurrent_calls=1
        )

    @property
    def evaluated_tokens(self) -> int:
        """Tokens evaluated since the start."""
        return self._sequences.evaluated_tokens

    def count_tokens(self, messages: Sequence[ChatMessage]) -> int:
        """Return how many tokens a chat has as the beginning of a prompt."""
        text = self._template.render(messages, answer_follows=False)
        return len(self._model.tokenize(text, special=True))

    def close(self) -> None:
        """Free context and weights. Idempotent."""
        self._sequences.close()
        self._model.close()

    def warm_up(self) -> None:
        """Evaluate one small request: page in the weights, build the compute graphs."""
        from w2c.clock import RealClock

        budget = Budget(RealClock(), 600.0)
        self.generate(_WARM_UP_CHAT, _WARM_UP_SCHEMA, Sampling(0.0, 0, 16), 0, budget)

    def generate(
        self,
        messages: Sequence[ChatMessage],
        schema: JsonSchema,
        sampling: Sampling,
        constant_messages: int,
        budget: Budget,
    ) -> Generation:
        """Continue a chat with compact JSON of a schema; properties in the order of the schema."""
        constraint = self._compiler.start(schema)
        tokens, prefix = self._prompt(messages, constant_messages)
        room = min(sampling.max_tokens, self._limit - len(tokens))
        started = time.monotonic()
        prefilled = self._sequences.begin(tokens, prefix, room, budget)
        prefill_ms = 1e3 * (time.monotonic() - started)
        answer, complete = self._decode(constraint, prefilled.logits, sampling, room, budget)
        usage = Usage(
            prompt_tokens=len(tokens),
            reused_tokens=prefilled.reused_tokens,
            completion_tokens=len(answer),
            prefill_ms=prefill_ms,
            decode_ms=1e3 * (time.monotonic() - started) - prefill_ms,
        )
        return Generation(self._model.detokenize(answer), complete, usage)

    def _decode(
        self,
        constraint: Constraint,
        logits: Logits,
        sampling: Sampling,
        room: int,
        budget: Budget,
    ) -> tuple[list[int], bool]:
        """Return the tokens of the answer, and whether it is whole."""
        random = np.random.default_rng(sampling.seed)
        answer: list[int] = []
        while True:
            budget.check()
            # Tokens without alternative need no look at the logits: one batch for all of them.
            chosen = constraint.forced()
            if not chosen and not constraint.finished:
                token = pick(logits, constraint.allowed(), sampling.temperature, random)
                if self._model.is_end(token):
                    return answer, True
                constraint.take([token])
                chosen = [token]
            answer += chosen
            if constraint.finished:
                return answer, True
            if len(answer) >= room:
                return answer[:room], False
            logits = self._sequences.extend(chosen, budget)

    def score(
        self,
        messages: Sequence[ChatMessage],
        options: Sequence[str],
        constant_messages: int,
        budget: Budget,
    ) -> Scores:
        """Return log P(option, end of turn | chat), exactly.

        The end counts: without it "left" would always be as likely as "left hand", or more.
        """
        tokens, prefix = self._prompt(messages, constant_messages)
        end = self._model.end_of_turn
        coded = [[*self._model.tokenize(option, special=False), end] for option in options]
        reserve = sum(map(len, coded))
        started = time.monotonic()
        prefilled = self._sequences.begin(tokens, prefix, reserve, budget)
        scores = self._sequences.continuations(prefilled.logits, coded, budget)
        elapsed_ms = 1e3 * (time.monotonic() - started)
        usage = Usage(
            prompt_tokens=len(tokens), reused_tokens=prefilled.reused_tokens, prefill_ms=elapsed_ms
        )
        return Scores(scores, usage)

    def _prompt(
        self, messages: Sequence[ChatMessage], constant_messages: int
    ) -> tuple[list[int], int]:
        """Return the tokens of a chat, and how many of them its constant messages give.

        The chat is tokenised whole, so that reuse never changes a token: the prefix is what both
        tokenisations share.
        """
        tokens = self._model.tokenize(self._template.render(messages), special=True)
        if len(tokens) + _LEAST_ANSWER > self._limit:
            raise RefusedError(
                f"the prompt has {len(tokens)} tokens, "
                f"the model takes {self._limit - _LEAST_ANSWER}; "
                "shorten the messages or use a model with a longer context"
            )
        if constant_messages == 0:
            return tokens, 0
        constant = self._template.render(messages[:constant_messages], answer_follows=False)
        shared = 0
        for mine, theirs in zip(
            tokens[:-1], self._model.tokenize(constant, special=True), strict=False
        ):
            if mine != theirs:
                break
            shared += 1
        return tokens, shared


def pick(
    logits: Logits, allowed: np.ndarray, temperature: float, random: np.random.Generator
) -> int:
    """Return the most likely allowed token at temperature 0, else a sample of the softmax."""
    masked = np.where(allowed, logits, -np.inf)
    if temperature <= 0.0:
        return int(masked.argmax())
    scaled = (masked - masked.max()) / temperature
    weights = np.exp(scaled.astype(np.float64))
    cumulative = np.cumsum(weights)
    return int(np.searchsorted(cumulative, random.random() * cumulative[-1], side="right"))
