"""What keeps an answer within its schema while it is made."""

from typing import Literal, Protocol

import numpy as np
import numpy.typing as npt

from w2c_llm.backend import JsonSchema
from w2c_llm.llama_model import LlamaModel

ConstraintKind = Literal["llguidance", "gbnf"]


class Constraint(Protocol):
    """The state of one constrained answer."""

    @property
    def finished(self) -> bool:
        """Whether the answer is whole and nothing can follow."""

    def forced(self) -> list[int]:
        """Take the tokens that have no alternative; empty where the model has a choice."""

    def allowed(self) -> npt.NDArray[np.bool_]:
        """Return (vocabulary,) True where a token may follow. Raises ModelError where none may."""

    def take(self, tokens: list[int]) -> None:
        """Tell the grammar what was chosen."""


class Compiler(Protocol):
    """Makes constraints for one vocabulary."""

    def start(self, schema: JsonSchema) -> Constraint:
        """Return the constraint of a fresh answer. Raises RefusedError for what it cannot do."""


def make_compiler(kind: ConstraintKind, model: LlamaModel) -> Compiler:
    """Return the compiler of a kind; the other one is not imported."""
    if kind == "gbnf":
        from w2c_llm.gbnf_constraint import GbnfCompiler

        return GbnfCompiler(model)
    from w2c_llm.guidance_constraint import GuidanceCompiler

    return GuidanceCompiler(model)
