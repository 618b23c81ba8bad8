"""Wraps a family: each thing of a picture, and what else is lit, is looked at from near."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Generic

import numpy as np
import torch

from w2c_grounding.boxes import area
from w2c_grounding.evidence import REGION_FRACTION, Region
from w2c_grounding.family import ContextT, Evidence, Family, Heatmap, RgbImage
from w2c_grounding.pretrained import Remembered
from w2c_grounding.second_look.crops import square_around
from w2c_grounding.second_look.network import WIDTH, SecondLookNetwork, said
from w2c_grounding.second_look.regions import worth_a_look
from w2c_grounding.second_look.weighing import weighed
from w2c_grounding.seen_near import SeenNear, seen_near
from w2c_grounding.things.proposals import Thing
from w2c_grounding.things.territory import Box, Territory, divided, lit, outside

_AT_ONCE = 256
"""Squares, to bound memory: a phrase has a few, a request up to 200 phrases"""
CLEAR = 0.2
"""Heat beside all things that is worth a look: what is fainter is a thing, or none"""
LEAST_BESIDE = 0.001
"""Of the picture: a smaller box beside all things is the glow of one"""


@dataclass(frozen=True)
class SeenThings(SeenNear[ContextT]):
    """And its things, each looked at from near."""

    territory: Territory
    looks: torch.Tensor
    """(things, WIDTH) what the second look sees of them"""


@dataclass(frozen=True)
class _Lit:
    """What a phrase lights."""

    heatmap: Heatmap
    things: tuple[Region, ...] = ()
    """Of the territory, each of its things"""
    others: tuple[Region, ...] = ()
    """To be looked at"""


class LooksAgain(Generic[ContextT]):
    """A family whose heat is weighed by a second look. Thread-safe.

    Where the things of a picture are found before anything is asked, each of them is looked at
    once, for all phrases; beside them what else a phrase lights. A phrase with a word that the
    second look does not know is left to the family, and so is what a family says with boxes of its
    own.
    """

    def __init__(
        self,
        family: Family[ContextT],
        network: SecondLookNetwork,
        device: str = "cpu",
        edge: float = REGION_FRACTION,
        find_things: Callable[[ContextT], Sequence[Thing]] | None = None,
    ) -> None:
        """Wrap a family.

        Args:
            family: Whose heat is weighed.
            network: Looks from near.
            device: Of the network.
            edge: Share of the peak at which a thing ends in heatmaps of the family.
            find_things: Returns the things of a picture; None = only what a phrase lights is looked
                at.
        """
        self.family = family
        # Squares come with their channels last, which is what convolutions are quickest with.
        last = torch.channels_last
        self._network: SecondLookNetwork = network.to(device).to(memory_format=last)  # type: ignore[call-overload]
        self._device = device
        self._edge = edge
        self._find_things = find_things
        self._meanings = Remembered[torch.Tensor]()

    def prepare(self, image: RgbImage) -> SeenNear[ContextT]:
        """Return what is kept of a picture."""
        near = seen_near(self.family, image)
        if self._find_things is None:
            return near
        territory = divided(self._find_things(near.context), *image.shape[:2])
        looks = self._looks(near, territory.boxes)
        return SeenThings(near.context, near.image, near.scale, territory, looks)

    def query(self, context: SeenNear[ContextT], phrases: Sequence[str]) -> list[Evidence]:
        """Return the evidence for each phrase."""
        found = self.family.query(context.context, phrases)
        lit_by = [
            self._lit(context, one.heatmap)
            if one.boxes is None and self._knows(phrase)
            else _Lit(one.heatmap)
            for phrase, one in zip(phrases, found, strict=True)
        ]
        logits = self._logits(context, phrases, lit_by)
        return [
            replace(one, heatmap=weighed(by.heatmap, [*by.things, *by.others], mine, self._edge))
            if mine
            else one
            for one, by, mine in zip(found, lit_by, logits, strict=True)
        ]

    def _knows(self, phrase: str) -> bool:
        content = said(phrase)
        return bool(content) and all(word in self._network.numbers for word in content)

    def _lit(self, context: SeenNear[ContextT], heatmap: Heatmap) -> _Lit:
        if not isinstance(context, SeenThings):
            return _Lit(heatmap, others=worth_a_look(heatmap, self._edge))
        others = [
            one
            for one in worth_a_look(outside(heatmap, context.territory), self._edge)
            if one.score >= CLEAR and area(one) >= LEAST_BESIDE * heatmap.size
        ]
        raised, things = lit(heatmap, context.territory, self._edge)
        return _Lit(raised, things, tuple(others))

    @torch.inference_mode()
    def _logits(
        self, context: SeenNear[ContextT], phrases: Sequence[str], lit_by: Sequence[_Lit]
    ) -> list[list[float]]:
        """Return one logit for each region of each phrase."""
        looks = self._looks(context, [_box(one) for by in lit_by for one in by.others])
        meanings = iter(
            self._meanings.get_all(
                [
                    phrase
                    for phrase, by in zip(phrases, lit_by, strict=True)
                    if by.things or by.others
                ],
                self._read,
            )
        )
        logits: list[list[float]] = []
        for by in lit_by:
            mine, looks = looks[: len(by.others)], looks[len(by.others) :]
            if by.things and isinstance(context, SeenThings):
                mine = torch.cat([context.looks, mine])
            if not len(mine):
                logits.append([])
                continue
            found = self._network.match(mine, next(meanings).expand(len(mine), -1))
            logits.append(found.float().tolist())
        return logits

    @torch.inference_mode()
    def _looks(self, context: SeenNear[ContextT], boxes: Sequence[Box]) -> torch.Tensor:
        """Return what is seen (n, WIDTH) of boxes of the picture [px]."""
        squares = [
            square_around(context.image, [context.scale * side for side in box]) for box in boxes
        ]
        seen = [
            self._see(squares[first : first + _AT_ONCE])
            for first in range(0, len(squares), _AT_ONCE)
        ]
        return torch.cat(seen) if seen else torch.zeros(0, WIDTH, device=self._device)

    def _see(self, squares: Sequence[RgbImage]) -> torch.Tensor:
        pixels = torch.from_numpy(np.stack(squares)).to(self._device).permute(0, 3, 1, 2)
        return self._network.see(pixels.float() / 255.0)

    def _read(self, phrases: list[str]) -> list[torch.Tensor]:
        tokens, lengths = self._network.tokens(phrases)
        return list(self._network.read(tokens.to(self._device), lengths.to(self._device)))


def _box(region: Region) -> Box:
    return region.left, region.top, region.right, region.bottom
