"""Wraps a family: each region that a phrase lights is looked at again, from near."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Generic

import cv2
import numpy as np
import numpy.typing as npt
import torch

from w2c_grounding.evidence import REGION_FRACTION, Region, regions_of
from w2c_grounding.family import ContextT, Evidence, Family, Heatmap, RgbImage
from w2c_grounding.pretrained import Remembered
from w2c_grounding.second_look.crops import brought_to_width, square_around
from w2c_grounding.second_look.network import SecondLookNetwork, said

TRUST = 0.6
"""What a logit of the second look counts beside one of the heat"""
FAINTEST = 0.05
"""Heat of a region that is worth a second look"""
LEAST_AREA = 0.0004
"""Of the picture: a smaller faint region is none of a thing"""
STEP = 4
"""What is faint is looked for in every such pixel: a heatmap is smooth, and this runs for each
phrase"""
MOST_REGIONS = 8
"""Of a phrase that are looked at, the hottest ones"""
MOST_CERTAIN = 9.0
"""Logit of a heat of 1: a model's heat of 1 is rounded, not certain"""
LARGEST_LOGIT = 14.0
"""Of both looks: beyond it single precision tells nothing from certainty"""
BESIDE = 0.9
"""Heat of all else, at most, over that at the edge of the surest region"""
_AT_ONCE = 256
"""Squares, to bound memory: a phrase has a few, a request up to 200 phrases"""


@dataclass(frozen=True)
class SeenTwice(Generic[ContextT]):
    """What both looks need of a picture."""

    context: ContextT
    image: RgbImage
    """Brought to the width of the training"""
    scale: float
    """Its pixels over those of the picture"""


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

    def prepare(self, image: RgbImage) -> SeenTwice[ContextT]:
        """Return what is kept of a picture."""
        small, scale = brought_to_width(image)
        return SeenTwice(self.family.prepare(image), small, scale)

    def query(self, context: SeenTwice[ContextT], phrases: Sequence[str]) -> list[Evidence]:
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
        context: SeenTwice[ContextT],
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


def worth_a_look(heatmap: Heatmap, edge: float = REGION_FRACTION) -> tuple[Region, ...]:
    """Return the regions to look at, the hottest first, at most `MOST_REGIONS`.

    Those of the heatmap, and beside them what is fainter than their edge: of two of a kind the
    family is often sure of one alone.
    """
    clear = regions_of(heatmap, FAINTEST, edge)
    level = edge * float(heatmap.max())
    if level <= FAINTEST:
        return clear[:MOST_REGIONS]
    coarse = heatmap[::STEP, ::STEP]
    lit = (coarse >= FAINTEST).astype(np.uint8)
    _, found, statistics, _ = cv2.connectedComponentsWithStats(lit, connectivity=8)
    labels = np.asarray(found, np.int32)
    known = {0, *np.unique(labels[coarse >= level]).tolist()}
    least = LEAST_AREA * coarse.size
    faint = [
        _hottest(heatmap, labels == label, np.asarray(statistics[label], np.int32), edge)
        for label in range(1, len(statistics))
        if label not in known and statistics[label][cv2.CC_STAT_AREA] >= least
    ]
    faint.sort(key=lambda region: -region.score)
    return (*clear, *faint)[:MOST_REGIONS]


def _hottest(
    heatmap: Heatmap,
    piece: npt.NDArray[np.bool_],
    statistics: npt.NDArray[np.int32],
    edge: float,
) -> Region:
    """Return the hottest region of a piece of a heatmap, which every `STEP`-th pixel shows."""
    left, top, width, height = (int(value) for value in statistics[:4])
    small = piece[top : top + height, left : left + width]
    left, top = STEP * left, STEP * top
    heat = heatmap[top : top + STEP * height, left : left + STEP * width]
    mask = small.repeat(STEP, axis=0).repeat(STEP, axis=1)[: heat.shape[0], : heat.shape[1]]
    alone = np.where(mask, heat, np.float32(0.0))
    found = regions_of(np.asarray(alone, np.float32), FAINTEST, edge)[0]
    return replace(
        found,
        left=left + found.left,
        top=top + found.top,
        right=left + found.right,
        bottom=top + found.bottom,
    )


def weighed(
    heatmap: Heatmap,
    regions: Sequence[Region],
    logits: Sequence[float],
    edge: float = REGION_FRACTION,
) -> Heatmap:
    """Return a heatmap whose regions are as hot as both looks together make them.

    The logit of a region's score becomes logit(heat) + `TRUST` x logit of the second look; its
    pixels keep their proportions. All else stays below the edge of the surest region.

    Args:
        heatmap: (height, width), 0 to 1.
        regions: Some of it; their score is the highest heat inside.
        logits: What the second look says of each, finite.
        edge: Share of the peak at which a thing ends.
    """
    scores = [_together(one.score, logit) for one, logit in zip(regions, logits, strict=True)]
    highest = max(scores)
    hottest = max(float(heatmap.max()), 1e-6)
    beside = np.float32(BESIDE * edge * highest)
    result: Heatmap = np.minimum(heatmap * np.float32(highest / hottest), beside)
    for region, score in zip(regions, scores, strict=True):
        window = np.s_[region.top : region.bottom, region.left : region.right]
        inside = heatmap[window][region.mask]
        result[window][region.mask] = inside * np.float32(score / region.score)
    return result


def _together(heat: float, logit: float) -> float:
    """Return the score of both looks, within (0, 1)."""
    least = 1.0 / (1.0 + np.exp(MOST_CERTAIN))
    bounded = min(max(heat, least), 1.0 - least)
    total = np.log(bounded / (1.0 - bounded)) + TRUST * logit
    return float(1.0 / (1.0 + np.exp(-np.clip(total, -LARGEST_LOGIT, LARGEST_LOGIT))))
