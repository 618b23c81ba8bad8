"""Large and small, by comparing: a model is asked for the rest of the phrase, and the sizes decide.

How large a thing is, no heatmap says by itself: "the small mug" is the smaller one of those that
are there. What counts is area and length in the picture, less where the picture is nearer; of two
alike, which one is meant stays open. A word of size says that there are several: where two that
touch are one region, it is parted.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Generic

import cv2
import numpy as np
import numpy.typing as npt

from w2c_grounding.evidence import REGION_FRACTION, Region, find, logit, regions_of, window_of
from w2c_grounding.family import ContextT, Evidence, Family, Heatmap, RgbImage, ScoredBox
from w2c_grounding.wording import FUNCTION_WORDS

SMALL = frozenset(
    {"small", "smaller", "smallest", "little", "tiny", "tinier", "tiniest", "smallish"}
)
LARGE = frozenset(
    {"large", "larger", "largest", "big", "bigger", "biggest", "huge", "giant", "largish"}
)
SIZE_WORDS = SMALL | LARGE
_NOTHING = FUNCTION_WORDS | {"object", "thing"}
"""Words that alone ask for nothing: `the small one` is left to the model"""

OTHERS = 0.75
"""Of the threshold: where one thing fits, another that is nearly as sure is there as well"""
AS_SURE = 0.25
"""Of the logit of the surest one: what is less sure is not of two of a kind, where several are as
sure as that. Beside a toolbox of 0.999 a piece of something at 0.8 is none"""
LITTLE = 1.5
"""Less than the logit of the surest one is as sure in any case"""
MOST_SURE = 14.0
"""Logit of a score of 1"""
LEAST_AREA = 0.0007
"""Of the picture: a smaller region is no thing to compare with, most often a stain"""
LEAST_SHARE = 0.05
"""Of the largest region: less is a piece of something"""
ALIKE = 1.01
"""Sizes that differ by less than this factor do not tell which is meant"""
NEARER = 0.8
"""How much longer a thing is at the lower edge of the picture than at the upper one, as a share of
its length in the middle: the camera looks down, and what is lower is nearer. Of 1,338 pairs of
training, true areas alone tell large from small in 85 %, with 0.6 in 89 %; decision 0020 says why
it is more on whole things"""
LEVELS = (0.5, 0.8, 0.95)
"""Shares of the peak at which things that touch come apart, where they are one at the usual edge"""
CUT_OFF = 1.3
"""How much larger than it looks a thing may be that the border of the picture cuts off"""
FADED = 0.9
"""Heat of all else, at most, over that at the edge of the chosen one: no region of its own"""


@dataclass(frozen=True)
class Sized:
    """A phrase without its word of size."""

    rest: str
    large: bool


def split(phrase: str, names: Sequence[str] = ()) -> Sized | None:
    """Return what a phrase asks for beside a size; None where it says none, or nothing else.

    Args:
        phrase: In lower case, words with single spaces between them.
        names: Of things; a word of size in one of them says none.
    """
    spoken = phrase.split(" ")
    named = _of_names(spoken, names)
    sizes = [at for at, word in enumerate(spoken) if word in SIZE_WORDS and at not in named]
    rest = [word for at, word in enumerate(spoken) if at not in sizes]
    if len(sizes) != 1 or sizes[0] == len(spoken) - 1 or _NOTHING.issuperset(rest):
        return None
    return Sized(" ".join(rest), spoken[sizes[0]] in LARGE)


def has_size(name: str) -> bool:
    """Tell whether a name has a word of size in it."""
    return not SIZE_WORDS.isdisjoint(name.split(" "))


def _of_names(spoken: Sequence[str], names: Sequence[str]) -> set[int]:
    """Return which words belong to names."""
    return {
        at
        for name in (text.split(" ") for text in names)
        for first in range(len(spoken) - len(name) + 1)
        if list(spoken[first : first + len(name)]) == name
        for at in range(first, first + len(name))
    }


def compared(
    evidence: Evidence, threshold: float, *, large: bool, edge: float = REGION_FRACTION
) -> Evidence:
    """Return the evidence of the largest, or smallest, of the things that fit.

    Where fewer than two fit, or the sizes do not tell, it stays as it is.

    Args:
        evidence: Of the phrase without its word of size.
        threshold: What scores less does not fit.
        large: Whether the largest is wanted.
        edge: Share of the peak at which a thing ends.
    """
    heatmap = evidence.heatmap
    finding = find(heatmap, OTHERS * threshold, boxes=evidence.boxes, edge=edge)
    if finding.score < threshold:
        return evidence
    regions = _large_enough(finding.regions, heatmap.size)
    if evidence.boxes is None:
        cores = regions if len(regions) > 1 else _apart(heatmap, OTHERS * threshold, edge)
        regions = _as_sure(_grown(cores, heatmap, edge))
    if len(regions) < 2:
        return evidence
    sizes = [_size(one, heatmap, large=large) for one in regions]
    first, second = sorted(range(len(regions)), key=sizes.__getitem__, reverse=large)[:2]
    if _alike(sizes[first], sizes[second]):
        return evidence
    chosen = regions[first]
    alone = _alone(heatmap, chosen, edge)
    # That it fits was decided above; the little more is for rounding.
    surer = max(1.0, (threshold + 1e-4) / chosen.score)
    boxes = None if evidence.boxes is None else (_box(replace(chosen, score=surer * chosen.score)),)
    return replace(evidence, heatmap=np.minimum(np.float32(surer) * alone, 1.0), boxes=boxes)


def _large_enough(regions: Sequence[Region], pixels: int) -> list[Region]:
    """Return the regions that are no stain, and no piece of something."""
    largest = max((int(np.count_nonzero(one.mask)) for one in regions), default=0)
    least = max(LEAST_AREA * pixels, LEAST_SHARE * largest)
    return [one for one in regions if np.count_nonzero(one.mask) >= least]


def _as_sure(regions: Sequence[Region]) -> list[Region]:
    """Return the regions that are nearly as sure as the surest one."""
    sure = [logit(one.score, MOST_SURE) for one in regions]
    surest = max(sure, default=0.0)
    least = min(AS_SURE * surest, surest - LITTLE)
    return [one for one, own in zip(regions, sure, strict=True) if own >= least]


def _apart(heatmap: Heatmap, threshold: float, edge: float) -> list[Region]:
    """Return cores of things that touch, and are one region, at the lowest level that parts them.

    Where no level does, nothing is returned.
    """
    for level in LEVELS:
        cores = _large_enough(regions_of(heatmap, threshold, level), heatmap.size)
        if level > edge and len(cores) >= 2:
            return cores
    return []


def _grown(cores: Sequence[Region], heatmap: Heatmap, edge: float) -> list[Region]:
    """Return each region out to where its own heat ends.

    At one level for all, what the model is less sure of would look smaller. What lies between two
    goes to the nearest.
    """
    window = window_of(heatmap >= edge * min((core.score for core in cores), default=np.inf))
    if window is None:
        return []
    top, left = window[0].start, window[1].start
    heat = heatmap[window]
    inside = [core.moved(-left, -top) for core in cores]
    outside = np.ones(heat.shape, np.uint8)
    for core in inside:
        outside[core.top : core.bottom, core.left : core.right][core.mask] = 0
    _, labels = cv2.distanceTransformWithLabels(
        outside, cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_CCOMP
    )
    nearest = np.asarray(labels, np.int32)
    return [_around(core, heat, edge, nearest).moved(left, top) for core in inside]


def _around(core: Region, heatmap: Heatmap, edge: float, nearest: npt.NDArray[np.int32]) -> Region:
    """Return what is connected with a region, nearest to it, and has a share of its peak."""
    rows, columns = slice(core.top, core.bottom), slice(core.left, core.right)
    label = nearest[rows, columns][core.mask][0]
    mine = ((heatmap >= edge * core.score) & (nearest == label)).astype(np.uint8)
    _, labels, statistics, _ = cv2.connectedComponentsWithStats(mine, connectivity=8)
    hottest = np.argmax(np.where(core.mask, heatmap[rows, columns], -1.0))
    piece = int(labels[rows, columns].flat[hottest])
    left, top, width, height, _ = (int(value) for value in statistics[piece])
    mask = np.asarray(labels[top : top + height, left : left + width] == piece)
    return Region(left, top, left + width, top + height, core.score, mask)


def _size(region: Region, heatmap: Heatmap, *, large: bool) -> float:
    """Return how large a thing is, in square pixels of the middle of the picture.

    It is the geometric mean of its area and its squared length: in front of a thing may be another,
    and of a thing that stands upright less is seen than of one that lies. For who looks for a small
    one, what the border cuts off may be larger than it looks. Decision 0020 says on what this was
    chosen.
    """
    length = max(region.right - region.left, region.bottom - region.top)
    seen = length * math.sqrt(np.count_nonzero(region.mask)) / _length_at(region, len(heatmap)) ** 2
    return seen * CUT_OFF if not large and _cut_off(region, heatmap) else seen


def _length_at(region: Region, height: int) -> float:
    """Return how long things look at the middle of a region; 1 in the middle of the picture."""
    return 1.0 + NEARER * (0.5 * (region.top + region.bottom) / height - 0.5)


def _cut_off(region: Region, heatmap: Heatmap) -> bool:
    """Tell whether a region reaches the border of the picture."""
    height, width = heatmap.shape
    return region.left <= 0 or region.top <= 0 or region.right >= width or region.bottom >= height


def _alike(one: float, other: float) -> bool:
    return max(one, other) < ALIKE * min(one, other)


def _alone(heatmap: Heatmap, chosen: Region, edge: float) -> Heatmap:
    """Return a heatmap in which nothing but one region is hot."""
    window = np.s_[chosen.top : chosen.bottom, chosen.left : chosen.right]
    peak = float(heatmap[window][chosen.mask].max())
    faint = heatmap * np.float32(FADED * edge * peak / max(float(heatmap.max()), 1e-6))
    faint[window][chosen.mask] = heatmap[window][chosen.mask]
    return faint


def _box(region: Region) -> ScoredBox:
    return ScoredBox(
        float(region.left),
        float(region.top),
        float(region.right),
        float(region.bottom),
        region.score,
    )


class ComparesSizes(Generic[ContextT]):
    """Wraps a family that does not know large from small."""

    def __init__(
        self,
        family: Family[ContextT],
        threshold: float,
        edge: float = REGION_FRACTION,
        names: Sequence[str] = (),
    ) -> None:
        """Wrap a family; see `compared` for threshold and edge, `split` for names."""
        self.family = family
        self._threshold = threshold
        self._edge = edge
        self._names = tuple(names)

    def prepare(self, image: RgbImage) -> ContextT:
        """Return what the model keeps of a picture."""
        return self.family.prepare(image)

    def query(self, context: ContextT, phrases: Sequence[str]) -> list[Evidence]:
        """Return the evidence for each phrase."""
        sized = [split(phrase, self._names) for phrase in phrases]
        asked = [
            phrase if one is None else one.rest for phrase, one in zip(phrases, sized, strict=True)
        ]
        found = self.family.query(context, asked)
        return [
            one
            if size is None
            else compared(one, self._threshold, large=size.large, edge=self._edge)
            for one, size in zip(found, sized, strict=True)
        ]
