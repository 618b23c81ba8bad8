"""A model that can be shown a picture and asked about it, wherever it runs."""

from dataclasses import dataclass
from typing import Literal, Protocol

from w2c_grounding.family import RgbImage


@dataclass(frozen=True)
class Turn:
    """One turn of a talk about a picture; the first is the question."""

    role: Literal["user", "assistant"]
    text: str


@dataclass(frozen=True)
class Shown:
    """A picture as the model gets it."""

    width: int
    height: int
    """As sent [px]"""
    picture: object
    """Of the talker; opaque elsewhere"""


class Talker(Protocol):
    """One vision-language model."""

    @property
    def at_once(self) -> int:
        """How many threads may ask at once."""

    def show(self, image: RgbImage) -> Shown:
        """Return the picture in the form that questions about it need, made once."""

    def ask(self, shown: Shown, turns: list[Turn]) -> str:
        """Return the answer to the last turn.

        Raises:
            DeadlineError: it took too long.
            RefusedError: the model cannot be asked this.
            ModelError: there was no answer.
        """

    def warm_up(self) -> None:
        """Do what makes the first answer slow, unless it costs money."""

    def close(self) -> None:
        """Let go of the model. Idempotent."""
