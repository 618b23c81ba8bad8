"""Wraps a family: each region that a phrase lights is looked at again, from near."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Generic

import numpy as np
import numpy.typing as npt
import torch

from w2c_grounding.evidence import REGION_FRACTION, Region
from w2c_grounding.family import ContextT, Evidence, Family, RgbImage
from w2c_grounding.pretrained import Remembered
from w2c_grounding.second_look.crops import square_around
from w2c_grounding.second_look.network import SecondLookNetwork, said
from w2c_grounding.second_look.regions import worth_a_look
from w2c_grounding.second_look.weighing import weighed
from w2c_grounding.seen_near import SeenNear, seen_near

_AT_ONCE = 256
"""Squares, to bound memory: a phrase has a few, a request up to 200 phrases"""


class LooksAgain(Generic[ContextT]):
    """A family whose heat is weighed by a second look. Thread-safe.

    A phrase with a word that the second look does not know is left to the family, and so is what a
    family says with boxes of its own.
    """

    def __init__(
        self,
        family: Family[ContextT],
        network: SecondLookNetwork,
        device: str = "cpu",
        edge: float = REGION_FRACTION,
    ) -> None:
        """Wrap a family; a thing ends in its heatmaps at the share `edge` of the peak."""
        self.family = family
        self._network = network.to(device)
        self._device = device
        self._edge = edge
        self._meanings = Remembered[torch.Tensor]()

    def prepare(self, image: RgbImage) -> SeenNear[ContextT]:
        """Return what is kept of a picture."""
        return seen_near(self.family, image)

    def query(self, context: SeenNear[ContextT], phrases: Sequence[str]) -> list[Evidence]:
        """Return the evidence for each phrase."""
        found = self.family.query(context.context, phrases)
        regions = [
            worth_a_look(one.heatmap, self._edge)
            if one.boxes is None and self._knows(phrase)
            else ()
            for phrase, one in zip(phrases, found, strict=True)
        ]
        logits = iter(self._logits(context, phrases, regions))
        return [
            replace(
                one, heatmap=weighed(one.heatmap, mine, [next(logits) for _ in mine], self._edge)
            )
            if mine
            else one
            for one, mine in zip(found, regions, strict=True)
        ]

    def _knows(self, phrase: str) -> bool:
        content = said(phrase)
        return bool(content) and all(word in self._network.numbers for word in content)

    @torch.inference_mode()
    def _logits(
        self,
        context: SeenNear[ContextT],
        phrases: Sequence[str],
        regions: Sequence[Sequence[Region]],
    ) -> npt.NDArray[np.float32]:
        """Return one logit for each region of each phrase, in their order."""
        squares = [
            square_around(
                context.image,
                [context.scale * side for side in (one.left, one.top, one.right, one.bottom)],
            )
            for mine in regions
            for one in mine
        ]
        if not squares:
            return np.zeros(0, np.float32)
        meanings = self._meanings.get_all(
            [phrase for phrase, mine in zip(phrases, regions, strict=True) if mine], self._read
        )
        counts = [len(mine) for mine in regions if mine]
        meant = torch.stack(meanings).repeat_interleave(torch.tensor(counts), dim=0)
        logits = [
            self._network.match(self._see(squares[part]), meant[part])
            for first in range(0, len(squares), _AT_ONCE)
            for part in [slice(first, first + _AT_ONCE)]
        ]
        return np.asarray(torch.cat(logits).float().cpu().numpy(), np.float32)

    def _see(self, squares: Sequence[RgbImage]) -> torch.Tensor:
        pixels = torch.from_numpy(np.stack(squares)).to(self._device).permute(0, 3, 1, 2)
        return self._network.see(pixels.float() / 255.0)

    def _read(self, phrases: list[str]) -> list[torch.Tensor]:
        tokens, lengths = self._network.tokens(phrases)
        return list(self._network.read(tokens.to(self._device), lengths.to(self._device)))
