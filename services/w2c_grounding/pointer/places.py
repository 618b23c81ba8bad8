"""Numbers of an answer become pixels of the picture. Pure functions."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from w2c_grounding.adapters import heatmap_from_boxes, heatmap_from_points
from w2c_grounding.family import Evidence, ScoredBox
from w2c_grounding.pointer.options import Units

SCALES: dict[Units, float] = {"unit": 1.0, "hundred": 100.0, "thousand": 1000.0}

SLACK = 0.02
"""A point this far outside the picture, as a share of its size, was meant to be at its edge:
models round. One farther outside is a mistake and is dropped."""

NAMED = 1.0
"""Score of what an answer names: it says where, not how sure."""


@dataclass(frozen=True)
class Place:
    """A point (x, y) or a box (left, top, right, bottom) as an answer gives it; x right, y down."""

    numbers: tuple[float, ...]
    scale: float | None = None
    """What the far edge is called, where the format says so; None = it does not"""


@dataclass(frozen=True)
class Frame:
    """The picture, and how large the model got it [px]."""

    width: int
    height: int
    sent_width: int
    sent_height: int


def evidence_of(
    places: Sequence[Place], units: Units, frame: Frame, reach: float
) -> tuple[Evidence, int]:
    """Return the evidence of an answer, and how many of its places made no sense.

    Args:
        places: Of one answer; none = the model sees nothing that fits.
        units: Of the places whose format does not fix them.
        frame: The picture.
        reach: Radius of the region around a point, as a share of the picture's width.
    """
    scale = _scale_of(places, units)
    points: list[tuple[float, float]] = []
    boxes: list[ScoredBox] = []
    dropped = 0
    for place in places:
        pixels = _pixels(place, scale, frame)
        if len(pixels) == 4:
            box = box_within(pixels, frame)
            boxes += [box] if box else []
            dropped += box is None
        else:
            point = point_within(pixels, frame)
            points += [point] if point else []
            dropped += point is None
    width, height = frame.width, frame.height
    if boxes:
        # Who gives boxes and points means the same things: boxes say more.
        return Evidence(heatmap_from_boxes(boxes, width, height), tuple(boxes)), dropped
    radius = max(1.0, reach * width)
    heat = heatmap_from_points(points, [NAMED] * len(points), width, height, radius)
    return Evidence(heat), dropped


def point_within(pixels: Sequence[float], frame: Frame) -> tuple[float, float] | None:
    """Return a point of the picture, moved to its edge from just outside; None where it is none."""
    u, v = pixels
    if not (math.isfinite(u) and math.isfinite(v)):
        return None
    for value, size in ((u, frame.width), (v, frame.height)):
        if not -SLACK * size <= value <= (1.0 + SLACK) * size:
            return None
    # Half a pixel from the far edge: the edge itself belongs to no pixel.
    return min(max(u, 0.0), frame.width - 0.5), min(max(v, 0.0), frame.height - 0.5)


def box_within(pixels: Sequence[float], frame: Frame) -> ScoredBox | None:
    """Return the part of a box that is in the picture; None where there is none.

    Which corners were given does not matter.
    """
    if not all(math.isfinite(value) for value in pixels):
        return None
    left, right = sorted((pixels[0], pixels[2]))
    top, bottom = sorted((pixels[1], pixels[3]))
    left, right = max(left, 0.0), min(right, float(frame.width))
    top, bottom = max(top, 0.0), min(bottom, float(frame.height))
    return ScoredBox(left, top, right, bottom, NAMED) if left < right and top < bottom else None


def _scale_of(places: Sequence[Place], units: Units) -> float | None:
    """Return what the far edge is called in this answer; None = its number of pixels as sent."""
    if units == "pixels":
        return None
    if units != "auto":
        return SCALES[units]
    numbers = [number for place in places if place.scale is None for number in place.numbers]
    return 1.0 if all(number <= 1.0 for number in numbers) else 1000.0


def _pixels(place: Place, scale: float | None, frame: Frame) -> list[float]:
    full = place.scale or scale
    across = frame.width / (full or frame.sent_width)
    down = frame.height / (full or frame.sent_height)
    return [number * (down if index % 2 else across) for index, number in enumerate(place.numbers)]
