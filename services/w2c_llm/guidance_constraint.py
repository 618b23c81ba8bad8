"""Which tokens may come next: llguidance masks over the vocabulary of a GGUF model."""

import ctypes
import json
from collections import OrderedDict
from typing import Any

import llama_cpp
import llguidance
import numpy as np
import numpy.typing as npt

from w2c.errors import ModelError, RefusedError
from w2c_llm.backend import JsonSchema
from w2c_llm.llama_model import LlamaModel

_COMPACT: Any = {"whitespace_flexible": False}  # the type of the options has no public name
"""One way to write each value: fewer tokens, and the form that the embedded model was trained on"""
_KEPT_SCHEMAS = 64


class GuidanceConstraint:
    """The state of one constrained answer."""

    def __init__(self, matcher: "llguidance.LLMatcher", vocabulary_size: int) -> None:
        self._matcher = matcher
        self._vocabulary_size = vocabulary_size

    @property
    def finished(self) -> bool:
        """Whether the answer is whole and nothing can follow."""
        return bool(self._matcher.is_stopped())

    def forced(self) -> list[int]:
        """Take the tokens that have no alternative; empty where the model has a choice."""
        tokens: list[int] = self._matcher.compute_ff_tokens()
        self.take(tokens)
        return tokens

    def allowed(self) -> npt.NDArray[np.bool_]:
        """Return (vocabulary,) True where a token may follow.

        Raises:
            ModelError: the grammar needs more work for one token than its limits allow.
        """
        bits = np.frombuffer(self._matcher.compute_bitmask(), np.uint8)
        self._check()
        mask = np.unpackbits(bits, bitorder="little")[: self._vocabulary_size].astype(np.bool_)
        if len(mask) < self._vocabulary_size or not mask.any():
            raise ModelError("the grammar of the schema allows no token; the schema has no answer")
        return mask

    def take(self, tokens: list[int]) -> None:
        """Tell the grammar what was chosen."""
        if tokens and not self._matcher.consume_tokens(tokens):
            self._check()

    def _check(self) -> None:
        if self._matcher.is_error():
            raise ModelError(f"the grammar of the schema failed: {self._matcher.get_error():.300}")


class GuidanceCompiler:
    """Compiles schemas for one vocabulary; keeps the last ones."""

    def __init__(self, model: LlamaModel) -> None:
        self._size = model.vocabulary_size
        self._tokenizer = _tokenizer(model)
        self._compiled: OrderedDict[str, llguidance.LLMatcher] = OrderedDict()

    def start(self, schema: JsonSchema) -> GuidanceConstraint:
        """Return the constraint of a fresh answer.

        Raises:
            RefusedError: llguidance cannot compile the schema.
        """
        key = json.dumps(schema)
        if key not in self._compiled:
            self._compiled[key] = self._compile(key)
            if len(self._compiled) > _KEPT_SCHEMAS:
                self._compiled.popitem(last=False)
        self._compiled.move_to_end(key)
        return GuidanceConstraint(self._compiled[key].deep_copy(), self._size)

    def _compile(self, schema: str) -> "llguidance.LLMatcher":
        try:
            grammar = llguidance.LLMatcher.grammar_from_json_schema(schema, overrides=_COMPACT)
        except ValueError as error:
            raise RefusedError(f"schema: {error}") from error
        matcher = llguidance.LLMatcher(self._tokenizer, grammar, log_level=0)
        if matcher.is_error():
            raise RefusedError(f"schema: {matcher.get_error():.500}")
        return matcher


def _tokenizer(model: LlamaModel) -> llguidance.LLTokenizer:
    """Return llguidance's view of a vocabulary. Takes a second for 150,000 tokens.

    (`llguidance.llamacpp` has a helper for it, which calls functions that llama-cpp-python
    deprecates.)
    """
    pieces = [
        # The byte 0xff marks what no text can spell.
        (b"\xff" if model.is_control(token) else b"") + model.piece(token, special=True)
        for token in range(model.vocabulary_size)
    ]
    ends = [token for token in range(model.vocabulary_size) if model.is_end(token)]
    tokenize = llama_cpp.llama_cpp._lib.llama_tokenize  # no public name for the bare C function
    tokenizer: Any = llguidance.LLTokenizer  # its stub lacks this constructor
    made: llguidance.LLTokenizer = tokenizer.from_llamacpp(
        tokens=pieces,
        vocab_ptr=model.vocabulary,
        tokenize_fptr=ctypes.cast(tokenize, ctypes.c_void_p).value,
        eos_token=ends or [model.end_of_turn],
        slices=None,
    )
    return made
