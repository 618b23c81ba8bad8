"""Wraps a family: each region that a phrase lights is looked at again, from near."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Generic

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

    Those of the heatmap, and behind them what is fainter than their edge: of two of a kind the
    family is often sure of one alone.
    """
    level = edge * float(heatmap.max())
    coarse = heatmap[::STEP, ::STEP]
    lit = (coarse >= min(level, FAINTEST)).astype(np.uint8)
    _, labels, statistics, _ = cv2.connectedComponentsWithStats(lit, connectivity=8)
    clear: list[Region] = []
    faint: list[Region] = []
    for label in range(1, len(statistics)):
        left, top, width, height, area = (int(value) for value in statistics[label])
        piece = _Piece(heatmap, labels == label, (left, top, left + width, top + height))
        hottest = float(piece.heat.max())
        if hottest >= max(level, FAINTEST):
            clear += piece.regions(level / hottest)
        elif hottest >= FAINTEST and area >= LEAST_AREA * coarse.size:
            faint += piece.regions(edge)[:1]
    return (*_hottest_first(clear), *_hottest_first(faint))[:MOST_REGIONS]


def _hottest_first(regions: Sequence[Region]) -> list[Region]:
    return sorted(regions, key=lambda region: -region.score)


class _Piece:
    """A connected piece of a heatmap, alone in its window."""

    def __init__(
        self, heatmap: Heatmap, cells: npt.NDArray[np.bool_], box: tuple[int, int, int, int]
    ) -> None:
        """Cut it out.

        Args:
            heatmap: (height, width).
            cells: Which of every `STEP`-th pixel belong to it.
            box: Of those: left, top, and exclusive right, bottom.
        """
        # One more all around: its edge lies between two of those pixels.
        rows = slice(max(box[1] - 1, 0), box[3] + 1)
        columns = slice(max(box[0] - 1, 0), box[2] + 1)
        inside = cells[rows, columns]
        wider = cv2.dilate(inside.astype(np.uint8), np.ones((3, 3), np.uint8))
        self._left, self._top = STEP * columns.start, STEP * rows.start
        heat = heatmap[self._top : STEP * rows.stop, self._left : STEP * columns.stop]
        self._inside = _grown(inside, heat.shape)
        self.heat: Heatmap = heat * _grown(wider, heat.shape)

    def regions(self, edge: float) -> list[Region]:
        """Return its regions in the picture, the hottest first."""
        return [
            replace(
                one,
                left=self._left + one.left,
                top=self._top + one.top,
                right=self._left + one.right,
                bottom=self._top + one.bottom,
            )
            for one in regions_of(self.heat, FAINTEST, edge)
            # Not the rim of a neighbour.
            if self._inside[one.top : one.bottom, one.left : one.right][one.mask].any()
        ]


def _grown(cells: npt.NDArray[Any], shape: tuple[int, ...]) -> npt.NDArray[Any]:
    return cells.repeat(STEP, axis=0).repeat(STEP, axis=1)[: shape[0], : shape[1]]


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
    result: Heatmap = heatmap * np.float32(highest / hottest)
    np.minimum(result, beside, out=result)
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
