"""Answers of models, validated. What does not fit is a ModelError with the reason."""

from typing import Annotated, Any, Literal, TypeVar

import msgspec

from w2c.errors import ModelError
from w2c_dialogue.expressions import MAX_LENGTH
from w2c_dialogue.utterance import LETTERS

A = TypeVar("A", bound=msgspec.Struct)

Entry = Annotated[str, msgspec.Meta(min_length=1, max_length=100)]
Expression = Annotated[str, msgspec.Meta(min_length=1, max_length=MAX_LENGTH)]
Entries = Annotated[list[Entry], msgspec.Meta(max_length=len(LETTERS))]


class ObjectsAnswer(msgspec.Struct, frozen=True):
    """What a correction speaks of."""

    objects: Entries


class AnalysisAnswer(msgspec.Struct, frozen=True):
    """What an instruction speaks of, and whether the place is on it or relative to it."""

    position: Literal["absolute", "relative"]
    objects: Entries


class PointAnswer(msgspec.Struct, frozen=True):
    """Where to go, as arithmetic."""

    x: Expression
    y: Expression


class EffectorAnswer(msgspec.Struct, frozen=True):
    """What goes there, and what for."""

    effector: Literal["left_hand", "right_hand", "left_foot", "right_foot", "unspecified"]
    task: Literal["contact", "reach"]


def read(value: Any, answer_type: type[A]) -> A:
    """Validate a decoded answer; other fields (a chain of thought) are ignored."""
    try:
        return msgspec.convert(value, answer_type, strict=True)
    except msgspec.ValidationError as error:
        raise ModelError(f"the answer is not of the form that was asked for: {error}") from error
