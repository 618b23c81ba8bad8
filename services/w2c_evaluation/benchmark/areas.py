"""The accepted area of a place, from geometry.

Directions are those of the picture: left is a smaller u, behind is higher (a smaller v), in front
is lower. Beside a thing means: on the surface that it stands on, where that is seen and free, and
no farther from the thing in the world than a person would still call it so.
"""

import cv2
import numpy as np
import numpy.typing as npt

from w2c_evaluation.benchmark.sight import Mask, Sight, Thing, footprint_distance

SIDES = {"left": (-1, 0), "right": (1, 0), "behind": (0, -1), "front": (0, 1)}
"""(du, dv) in the picture"""
REACH_M = 0.30
"""Beside a thing reaches so far from its footprint"""
CLOSE_REACH_M = 0.20
"""Next to a thing"""
OPENING = 0.35
"""How much wider than the thing the area beside it gets, for each pixel away from it"""
MEASURE_TOLERANCE_M = 0.07
"""Of a distance that was said"""
END_SHARE = 0.4
"""So much of a thing is its left end"""
TOP_SHARE = 0.3
TOP_M = 0.02
"""The top of a thing reaches down by this share of its height, or this far"""
FLAT_M = 0.05
"""What is no higher is all top: a tray's floor lies below its rim"""


def on(sight: Sight, thing: Thing) -> Mask:
    """Return all that is seen of a thing."""
    return np.asarray(sight.identity == thing.id, dtype=np.bool_)


def on_top(sight: Sight, thing: Thing) -> Mask:
    """Return what is seen of the top of a thing."""
    height = thing.top - thing.foot
    if height <= FLAT_M:
        return on(sight, thing)
    least = thing.top - max(TOP_M, TOP_SHARE * height)
    return np.asarray(on(sight, thing) & (sight.world[:, :, 2] >= least), dtype=np.bool_)


def end_of(sight: Sight, thing: Thing, side: str) -> Mask:
    """Return the end of a thing on a side, as seen in the picture."""
    left, top, right, bottom = thing.edges
    du, dv = SIDES[side]
    kept = np.zeros(sight.identity.shape, bool)
    across = round(END_SHARE * (right - left))
    along = round(END_SHARE * (bottom - top))
    columns = {-1: slice(left, left + across), 1: slice(right - across, right)}.get(du, slice(None))
    rows = {-1: slice(top, top + along), 1: slice(bottom - along, bottom)}.get(dv, slice(None))
    kept[rows, columns] = True
    return np.asarray(on(sight, thing) & kept, dtype=np.bool_)


def beside(sight: Sight, thing: Thing, side: str) -> Mask:
    """Return the free surface on a side of a thing."""
    free = sight.free_surface(thing.foot) & _sector(sight, thing, side)
    return _within(sight, thing, free, (0.0, REACH_M))


def measured(sight: Sight, thing: Thing, side: str, distance_m: float) -> Mask:
    """Return the free surface at a distance from a thing, on a side."""
    free = sight.free_surface(thing.foot) & _sector(sight, thing, side)
    low, high = distance_m - MEASURE_TOLERANCE_M, distance_m + MEASURE_TOLERANCE_M
    return _within(sight, thing, free, (max(0.0, low), high))


def next_to(sight: Sight, thing: Thing) -> Mask:
    """Return the free surface around a thing, on any side."""
    return _within(sight, thing, sight.free_surface(thing.foot), (0.0, CLOSE_REACH_M))


def between(sight: Sight, first: Thing, second: Thing) -> Mask:
    """Return the free surface in the gap between two things that stand on the same surface."""
    corners = [
        (u, v)
        for left, top, right, bottom in (first.edges, second.edges)
        for u in (left, right - 1)
        for v in (top, bottom - 1)
    ]
    hull = cv2.convexHull(np.array(corners, np.int32))
    inside = np.zeros(sight.identity.shape, np.uint8)
    cv2.fillConvexPoly(inside, hull, 1)
    for left, top, right, bottom in (first.edges, second.edges):
        inside[top:bottom, left:right] = 0
    inside[:, :] &= _gap(sight, first, second)
    height = 0.5 * (first.foot + second.foot)
    return np.asarray(sight.free_surface(height, 0.02) & (inside > 0), dtype=np.bool_)


def _gap(sight: Sight, first: Thing, second: Thing) -> npt.NDArray[np.uint8]:
    """Return the strip between two boxes, along the axis with the wider gap."""
    one, other = first.edges, second.edges
    strip = np.zeros(sight.identity.shape, np.uint8)
    gaps = [(max(one[i], other[i]) - min(one[i + 2], other[i + 2]), i) for i in (0, 1)]
    size, axis = max(gaps)
    if size <= 0:
        return strip
    start, end = min(one[axis + 2], other[axis + 2]), max(one[axis], other[axis])
    if axis == 0:
        strip[:, start:end] = 1
    else:
        strip[start:end, :] = 1
    return strip


def _sector(sight: Sight, thing: Thing, side: str) -> Mask:
    """Return the part of the picture on a side of a thing, a little wider the farther away."""
    left, top, right, bottom = thing.edges
    height, width = sight.identity.shape
    u, v = np.arange(width)[None, :] + 0.5, np.arange(height)[:, None] + 0.5
    if side in ("left", "right"):
        away = left - u if side == "left" else u - right
        sideways = np.maximum(top - v, v - bottom)
    else:
        away = top - v if side == "behind" else v - bottom
        sideways = np.maximum(left - u, u - right)
    return np.asarray((away > 0) & (sideways <= OPENING * away), dtype=np.bool_)


def _within(sight: Sight, thing: Thing, free: Mask, reach_m: tuple[float, float]) -> Mask:
    """Return where a free surface is so far from a thing."""
    kept = np.zeros_like(free)
    distance = footprint_distance(thing, sight.world[free])
    kept[free] = (distance >= reach_m[0]) & (distance <= reach_m[1])
    return kept
