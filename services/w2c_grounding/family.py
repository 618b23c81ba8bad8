"""What every vision model looks like to the service, whatever it is inside."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, TypeVar

import numpy as np
import numpy.typing as npt

RgbImage = npt.NDArray[np.uint8]
"""(height, width, 3), indexed [v, u]"""

Heatmap = npt.NDArray[np.float32]
"""(height, width) of the picture, indexed [v, u]; the probability that the pixel belongs to the
phrase"""


@dataclass(frozen=True)
class Evidence:
    """What a model saw of one phrase, in pixels of the picture it was given."""

    heatmap: Heatmap


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
