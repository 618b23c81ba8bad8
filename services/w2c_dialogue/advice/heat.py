"""How strongly the picture shows a phrase around a place."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from w2c.messages import Box, PhraseEvidence


@dataclass(frozen=True)
class Place:
    """What a hand would cover, in a picture."""

    u: float
    v: float
    """Its middle [px]"""
    radius: float
    """[px]"""
    width: int
    height: int
    """Of the picture [px]"""


@dataclass(frozen=True)
class Hit:
    """A phrase that the picture shows at a place."""

    phrase: str
    heat: float
    """Highest value of the heatmap there, 0 to 1"""
    limit: float
    """From this value on the phrase counts as being there"""


def hits(evidence: Iterable[PhraseEvidence], place: Place, share: float) -> tuple[Hit, ...]:
    """Return the phrases that are found in the picture and seen at a place, strongest first.

    Args:
        evidence: What was found for each phrase.
        place: Where.
        share: Of a phrase's highest value in the picture, that counts as being there.
    """
    found = [
        Hit(seen.phrase, heat_at(seen, place), share * seen.score)
        for seen in evidence
        if seen.found
    ]
    there = [hit for hit in found if hit.heat >= hit.limit]
    return tuple(sorted(there, key=lambda hit: -hit.heat))


def heat_at(seen: PhraseEvidence, place: Place) -> float:
    """Return the highest heat of a phrase within a place, 0 to 1.

    A model that gives no heatmap is taken at its boxes: their score inside, nothing outside.
    """
    heatmap = seen.heatmap
    if heatmap is None:
        return max((box.score for box in seen.boxes if _touches(box, place)), default=0.0)
    rows, columns = heatmap.shape
    across, along = place.width / columns, place.height / rows  # pixels of the picture a cell
    row = min(max(int(place.v / along), 0), rows - 1)
    column = min(max(int(place.u / across), 0), columns - 1)
    u = (np.arange(columns) + 0.5) * across - place.u  # (columns,)
    v = (np.arange(rows) + 0.5) * along - place.v  # (rows,)
    near = heatmap[v[:, None] ** 2 + u**2 <= place.radius**2]
    # A place smaller than a cell may hold the middle of none.
    return max(int(heatmap[row, column]), int(near.max(initial=0))) / 255.0


def _touches(box: Box, place: Place) -> bool:
    du = max(box.left - place.u, 0.0, place.u - box.right)
    dv = max(box.top - place.v, 0.0, place.v - box.bottom)
    return du * du + dv * dv <= place.radius**2
