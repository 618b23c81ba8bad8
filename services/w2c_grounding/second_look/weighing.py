"""How hot regions are once both looks are put together."""

from collections.abc import Sequence

import numpy as np

from w2c_grounding.evidence import REGION_FRACTION, Region, logit
from w2c_grounding.family import Heatmap

TRUST = 0.8
"""What a logit of the second look counts beside one of the heat"""
MOST_CERTAIN = 9.0
"""Logit of a heat of 1: a model's heat of 1 is rounded, not certain"""
LARGEST_LOGIT = 14.0
"""Of both looks: beyond it single precision tells nothing from certainty"""
BESIDE = 0.9
"""Heat of all else, at most, over that at the edge of the surest region"""


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
    scores = [_together(one.score, second) for one, second in zip(regions, logits, strict=True)]
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


def _together(heat: float, second: float) -> float:
    """Return the score of both looks, within (0, 1)."""
    total = logit(heat, MOST_CERTAIN) + TRUST * second
    return float(1.0 / (1.0 + np.exp(-np.clip(total, -LARGEST_LOGIT, LARGEST_LOGIT))))
