"""How well boxes fit things, before and after their outlines are drawn."""

from collections.abc import Iterable
from typing import Any

import cv2
import numpy as np

from w2c_grounding.boxes import intersection_over_union
from w2c_grounding.evidence import Mask, Region
from w2c_grounding.family import ScoredBox
from w2c_grounding.outline.draws_outlines import DrawsOutlines, regions_to_draw
from w2c_grounding.train.outline.samples import Lit

WELL = 0.75
"""Intersection over union of boxes that fit well"""


def overlaps(
    some: Iterable[Lit], outlines: DrawsOutlines[Any], least: float, edge: float
) -> dict[str, float]:
    """Return the mean overlap of boxes with things, and the share of those that fit well.

    Args:
        some: What a family lit.
        outlines: Draws.
        least: Score of a region that counts.
        edge: Share of the peak at which a thing ends.
    """
    before: list[float] = []
    after: list[float] = []
    for one in some:
        wanted = _box(one.thing)
        before.append(intersection_over_union(_around(one.region), wanted))
        drawn = outlines.redrawn(one.heatmap, one.image, one.scale)
        found = [_around(region) for region in regions_to_draw(drawn, least, edge)]
        mine = _around(one.region)
        same = max(found, key=lambda box: intersection_over_union(box, mine), default=None)
        after.append(0.0 if same is None else intersection_over_union(same, wanted))
    scores = {}
    for name, values in (("family", before), ("outlines", after)):
        scores[f"overlap.{name}"] = float(np.mean(values)) if values else float("nan")
        scores[f"fit_well.{name}"] = (
            float(np.mean([value >= WELL for value in values])) if values else float("nan")
        )
    return scores


def _around(region: Region) -> ScoredBox:
    return ScoredBox(region.left, region.top, region.right, region.bottom, region.score)


def _box(thing: Mask) -> ScoredBox:
    left, top, width, height = cv2.boundingRect(thing.astype(np.uint8))
    return ScoredBox(left, top, left + width, top + height, 1.0)
