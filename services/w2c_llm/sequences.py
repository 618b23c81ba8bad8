"""One llama.cpp context, many sequences: a constant prefix is evaluated once, copied for free.

Sequence 0 is where the current request is evaluated. The next `OPTIONS` sequences hold the options
of a choice, which share the prompt. The rest each keep a prefix that requests have in common. In a
unified cache a copy of a sequence is only a mark on its cells, so a prefix costs its memory once,
however often it is used.

Sequences are only ever copied and removed as a whole, which models with recurrent layers allow too.
"""

import ctypes
from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass

import llama_cpp
import numpy as np
import numpy.typing as npt

from w2c.errors import ModelError, RefusedError
from w2c_llm.backend import Budget
from w2c_llm.llama_model import LlamaModel

Logits = npt.NDArray[np.float32]

WORK = 0
OPTIONS = 32
"""Options of a choice that are evaluated in one batch: as many as a request may have"""
_ROWS = 64
"""Tokens of options in one batch: the logits of each take 0.6 MB with a large vocabulary"""
_BATCH = 512
_CELL_ROUNDING = 256
"""llama.cpp rounds a context up to this; asking for less makes its own checks fail late"""


@dataclass(frozen=True)
class Row:
    """One token in a batch."""

    token: int
    position: int
    sequence: int
    wants_logits: bool


@dataclass(frozen=True)
class Prefilled:
    """What became of a prompt."""

    logits: Logits
    """(vocabulary,) for the token after the prompt"""
    reused_tokens: int


class Sequences:
    """The key-value cache of one model. Not thread-safe: one thread uses it."""

    def __init__(
        self,
        model: LlamaModel,
        context: int,
        threads: int,
        *,
        prefixes: int = 16,
        batch: int = _BATCH,
    ) -> None:
        """Make the context.

        Args:
            model: The weights.
            context: Cells in all [tokens], shared by all sequences.
            threads: For evaluation.
            prefixes: How many prefixes may be kept.
            batch: Tokens that are evaluated at once; between batches a request can end.

        Raises:
            ModelError: llama.cpp cannot allocate it.
        """
        self._model = model
        self.cells = -(-context // _CELL_ROUNDING) * _CELL_ROUNDING
        parameters = llama_cpp.llama_context_default_params()
        parameters.n_ctx = self.cells
        parameters.n_batch = parameters.n_ubatch = _BATCH
        parameters.n_seq_max = 1 + OPTIONS + prefixes
        parameters.kv_unified = True
        parameters.n_threads = parameters.n_threads_batch = threads
        self._context = llama_cpp.llama_init_from_model(model.handle, parameters)
        if not self._context:
            raise ModelError(
                f"llama.cpp cannot make a context of {self.cells} tokens; use a smaller --context"
            )
        self._memory = llama_cpp.llama_get_memory(self._context)
        self._batch_size = min(batch, _BATCH)
        self._batch = llama_cpp.llama_batch_init(_BATCH, 0, 1)
        self._free = list(range(1 + OPTIONS, 1 + OPTIONS + prefixes))
        # The tokens of a prefix to its sequence; least recently used first.
        self._prefixes: OrderedDict[tuple[int, ...], int] = OrderedDict()
        self._length = 0
        self.evaluated_tokens = 0
        """In all, since the start: what reuse saves shows here"""

    def close(self) -> None:
        """Free the context. Idempotent."""
        if self._context:
            llama_cpp.llama_batch_free(self._batch)
            llama_cpp.llama_free(self._context)
            self._context = None

    def begin(
        self, tokens: Sequence[int], prefix_length: int, reserve: int, budget: Budget
    ) -> Prefilled:
        """Evaluate a prompt in the work sequence.

        Args:
            tokens: The prompt.
            prefix_length: How many of its tokens other requests begin with too; below len(tokens).
            reserve: Tokens that will be added.
            budget: Checked between batches.

        Raises:
            RefusedError: prompt and reserve do not fit the context.
        """
        if len(tokens) + reserve > self.cells:
            raise RefusedError(
                f"{len(tokens)} tokens of prompt and {reserve} of answer exceed "
                f"the context of {self.cells}; "
                "shorten the messages or use a larger --context"
            )
        self._clear(WORK)
        prefix = tuple(tokens[:prefix_length])
        reused = 0
        if prefix:
            reused = len(prefix) if prefix in self._prefixes else 0
            self._make_room(prefix, len(tokens) + reserve)
            sequence = self._prefix_sequence(prefix, budget)
            llama_cpp.llama_memory_seq_cp(self._memory, sequence, WORK, -1, -1)
        else:
            self._make_room(prefix, len(tokens) + reserve)
        self._length = len(prefix)
        return Prefilled(self.extend(tokens[len(prefix) :], budget), reused)

    def extend(self, tokens: Sequence[int], budget: Budget) -> Logits:
        """Evaluate more tokens, at least one; return the (vocabulary,) logits after them."""
        logits = self._evaluate(tokens, self._length, WORK, budget)
        self._length += len(tokens)
        return logits

    def continuations(
        self, after_prompt: Logits, options: Sequence[Sequence[int]], budget: Budget
    ) -> list[float]:
        """Return the log-likelihood of each option (at least one token) after the work sequence."""
        first = log_softmax(after_prompt)
        result: list[float] = []
        for group in _groups(options):
            budget.check()
            result += self._score_group(first, group)
        return result

    def _score_group(self, first: Logits, group: Sequence[Sequence[int]]) -> list[float]:
        rows: list[Row] = []
        for sequence, tokens in enumerate(group, start=1):
            self._clear(sequence)
            llama_cpp.llama_memory_seq_cp(self._memory, WORK, sequence, -1, -1)
            # The last token is scored, not evaluated: nothing follows it.
            rows += [
                Row(token, self._length + offset, sequence, True)
                for offset, token in enumerate(tokens[:-1])
            ]
        table: list[Logits] = []
        for start in range(0, len(rows), self._batch_size):
            part = rows[start : start + self._batch_size]
            self._decode(part)
            table += [self._logits(index) for index in range(len(part))]
        scores: list[float] = []
        row = 0
        for sequence, tokens in enumerate(group, start=1):
            score = float(first[tokens[0]])
            for token in tokens[1:]:
                score += float(log_softmax(table[row])[token])
                row += 1
            scores.append(score)
            self._clear(sequence)
        return scores

    def _prefix_sequence(self, prefix: tuple[int, ...], budget: Budget) -> int:
        """Return the sequence that holds a prefix, evaluating it where it is new."""
        if prefix in self._prefixes:
            self._prefixes.move_to_end(prefix)
            return self._prefixes[prefix]
        if not self._free:
            self._evict(next(iter(self._prefixes)))
        sequence = self._free.pop()
        try:
            self._evaluate(prefix, 0, sequence, budget)
        except BaseException:
            # Half a prefix is no prefix: the sequence goes back empty.
            self._clear(sequence)
            self._free.append(sequence)
            raise
        self._prefixes[prefix] = sequence
        return sequence

    def _make_room(self, prefix: tuple[int, ...], needed: int) -> None:
        """Forget prefixes, least recently used first, until `needed` cells are free."""
        others = [held for held in self._prefixes if held != prefix]
        used = sum(len(held) for held in others)
        for held in others:
            if used + needed <= self.cells:
                return
            self._evict(held)
            used -= len(held)

    def _evict(self, prefix: tuple[int, ...]) -> None:
        sequence = self._prefixes.pop(prefix)
        self._clear(sequence)
        self._free.append(sequence)

    def _clear(self, sequence: int) -> None:
        llama_cpp.llama_memory_seq_rm(self._memory, sequence, -1, -1)

    def _evaluate(
        self, tokens: Sequence[int], position: int, sequence: int, budget: Budget
    ) -> Logits:
        """Evaluate tokens batch by batch; return the logits after the last."""
        last = len(tokens) - 1
        for start in range(0, len(tokens), self._batch_size):
            budget.check()
            part = range(start, min(start + self._batch_size, len(tokens)))
            self._decode([Row(tokens[at], position + at, sequence, at == last) for at in part])
        return self._logits(last % self._batch_size)

    def _decode(self, rows: Sequence[Row]) -> None:
        """Evaluate one batch. On failure all is forgotten: the next request starts clean."""
        if not rows:
            return
        batch = self._batch
        batch.n_tokens = len(rows)
        for index, row in enumerate(rows):
            batch.token[index] = row.token
            batch.pos[index] = row.position
            batch.n_seq_id[index] = 1
            batch.seq_id[index][0] = row.sequence
            batch.logits[index] = row.wants_logits
        status = llama_cpp.llama_decode(self._context, batch)
        self.evaluated_tokens += len(rows)
        if status != 0:
            llama_cpp.llama_memory_clear(self._memory, True)
            self._free += self._prefixes.values()
            self._prefixes.clear()
            raise ModelError(
                f"llama.cpp failed to evaluate {len(rows)} tokens "
                f"(status {status}, context {self.cells})"
            )

    def _logits(self, index: int) -> Logits:
        """Return a copy of the logits of a row of the last batch: llama.cpp overwrites them."""
        pointer = llama_cpp.llama_get_logits_ith(self._context, index)
        if not ctypes.cast(pointer, ctypes.c_void_p):
            raise ModelError(f"llama.cpp has no logits for row {index}")
        array = np.ctypeslib.as_array(pointer, (self._model.vocabulary_size,))
        return np.array(array, dtype=np.float32)


def _groups(options: Sequence[Sequence[int]]) -> list[list[Sequence[int]]]:
    """Return the options in their order, cut where a batch is full."""
    groups: list[list[Sequence[int]]] = []
    rows = 0
    for option in options:
        rows += len(option) - 1
        if not groups or len(groups[-1]) == OPTIONS or rows > _ROWS:
            groups.append([])
            rows = len(option) - 1
        groups[-1].append(option)
    return groups


def log_softmax(logits: Logits) -> Logits:
    """Return the logarithm of the probabilities, (vocabulary,)."""
    shifted = logits - logits.max()
    result: Logits = shifted - np.log(np.exp(shifted).sum())
    return result
