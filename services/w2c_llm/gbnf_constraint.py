"""Which tokens may come next, by llama.cpp's own grammars: for where llguidance has no wheel.

A mask over 150,000 tokens takes a hundred times longer than llguidance's.
"""

import ctypes
from typing import Any

import llama_cpp
import numpy as np
import numpy.typing as npt

from w2c.errors import ModelError
from w2c_llm.backend import JsonSchema
from w2c_llm.gbnf import ROOT, check_grammar, grammar_text
from w2c_llm.llama_model import LlamaModel

_CANDIDATE = np.dtype([("id", np.int32), ("logit", np.float32), ("p", np.float32)])


class GbnfConstraint:
    """The state of one constrained answer."""

    finished = False
    """Never known here: a whole answer is one after which only the end may follow"""

    def __init__(self, sampler: Any, vocabulary_size: int) -> None:
        self._sampler = sampler
        self._candidates = np.zeros(vocabulary_size, _CANDIDATE)

    def __del__(self) -> None:
        llama_cpp.llama_sampler_free(self._sampler)

    def forced(self) -> list[int]:
        """Return no token: this grammar looks ahead by one only."""
        return []

    def allowed(self) -> npt.NDArray[np.bool_]:
        """Return (vocabulary,) True where a token may follow."""
        candidates = self._candidates
        candidates["id"] = np.arange(len(candidates))
        candidates["logit"] = 0.0
        array = llama_cpp.llama_token_data_array(
            data=candidates.ctypes.data_as(ctypes.POINTER(llama_cpp.llama_token_data)),
            size=len(candidates),
            selected=-1,
            sorted=False,
        )
        llama_cpp.llama_sampler_apply(self._sampler, ctypes.byref(array))
        mask: npt.NDArray[np.bool_] = np.isfinite(candidates["logit"])
        if not mask.any():
            raise ModelError("the grammar of the schema allows no token; the schema has no answer")
        return mask

    def take(self, tokens: list[int]) -> None:
        """Tell the grammar what was chosen, which it must allow: else it ends the process."""
        for token in tokens:
            llama_cpp.llama_sampler_accept(self._sampler, token)


class GbnfCompiler:
    """Compiles schemas for one vocabulary."""

    def __init__(self, model: LlamaModel) -> None:
        self._model = model

    def start(self, schema: JsonSchema) -> GbnfConstraint:
        """Return the constraint of a fresh answer.

        Raises:
            RefusedError: the schema has no GBNF form that llama.cpp takes.
        """
        text = grammar_text(schema)
        check_grammar(text, self._model.vocabulary)
        sampler = llama_cpp.llama_sampler_init_grammar(
            self._model.vocabulary, text.encode(), ROOT.encode()
        )
        return GbnfConstraint(sampler, self._model.vocabulary_size)
