"""What every vision model looks like to the service, whatever it is inside."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol, TypeVar

import numpy as np
import numpy.typing as npt

RgbImage = npt.NDArray[np.uint8]
"""(height, width, 3), indexed [v, u]"""

Heatmap = npt.NDArray[np.float32]
"""(height, width) of the picture, indexed [v, u]; the probability that the pixel belongs to the
phrase"""


class ScoredBox(NamedTuple):
    """A box in pixels of the original picture, as a model gave it: not necessarily a sound one.

    (left, top) inclusive, (right, bottom) exclusive; u right, v down.
    """

    left: float
    top: float
    right: float
    bottom: float
    score: float
    """Probability that the box shows what the phrase says, 0 to 1"""


@dataclass(frozen=True)
class Evidence:
    """What a model saw of one phrase, in pixels of the picture it was given.

    A family fills what its models give; `adapters` makes a heatmap of boxes, masks, polygons and
    points. Nothing of it needs to be sound: boxes may leave the picture or hold NaN. Who reads it
    checks.
    """

    heatmap: Heatmap
    boxes: tuple[ScoredBox, ...] | None = None
    """In any order, weak ones too: the threshold is applied later, and the best score says how far
    from it a phrase was. None = the family gives none, and the regions of the heatmap count; () =
    it looked, and saw nothing"""
    unknown_words: tuple[str, ...] = ()
    """Words of the phrase that the model cannot read, such as those of a script its tokenizer does
    not have; empty where the family cannot tell"""


ContextT = TypeVar("ContextT")


class Family(Protocol[ContextT]):
    """A kind of vision model.

    `prepare` does what depends on the picture alone, once; `query` answers phrases about it, as
    often as asked. Both are stateless towards the caller: the same picture and phrases give the
    same evidence.
    """

    def prepare(self, image: RgbImage) -> ContextT:
        """Return what the model keeps of a picture."""

    def query(self, context: ContextT, phrases: Sequence[str]) -> list[Evidence]:
        """Return the evidence for each phrase, in their order; none influences another."""
