"""How a surface goes on around a point: seen, covered by something, or ended.

Rings in the plane of the surface are projected into the picture. What the camera measures there
tells what is at that place: the plane itself; something nearer, which hides it or stands on it;
something farther, so that there is no surface; or nothing.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from w2c.geometry import Intrinsics, Vector, frame_from_normal
from w2c_perception.window import DepthPicture, Points

LARGEST = 0.25
"""Nobody asks how a surface goes on beyond this [m]"""
RING_STEP = 0.005
RING_POINTS = 48
_ANGLES = np.linspace(0.0, 2.0 * np.pi, RING_POINTS, endpoint=False)[:, None]
_COSINES, _SINES = np.cos(_ANGLES), np.sin(_ANGLES)
TOLERANCE = 0.006
"""Depth this far from the plane is another surface [m]"""
NOISY = 3.0
"""... or so many standard deviations of noise"""
MISSING_SHARE = 0.1
"""A ring of which a larger share is not the surface ends it"""
ENDED_RINGS = 3
"""Rings in a row that see past the surface in one direction, or nothing: it ends there, it is no
hole"""


@dataclass(frozen=True)
class Surroundings:
    """Of a point on a surface."""

    extent: float
    """Radius up to which the flat surface is seen all around [m]; outside of the picture, hidden
    and covered places are not seen"""
    edge_distance: float
    """To the nearest place where the surface ends, because what is behind it is seen [m];
    `LARGEST` where it does not within that"""


def look_around(
    depth: DepthPicture, intrinsics: Intrinsics, point: Vector, normal: Vector, sigma: float
) -> Surroundings:
    """Return how the surface goes on around a point.

    Args:
        depth: (h, w) z-depth [m], 0 = unknown.
        intrinsics: of the camera.
        point: (3,) on the surface, in the camera frame [m].
        normal: (3,) of the surface, towards the camera.
        sigma: noise of depth at the point [m].
    """
    radii = np.arange(RING_STEP, LARGEST + 1e-9, RING_STEP)
    rings = point + radii[:, None, None] * circle(normal)  # (radii, ring, 3)
    z = np.maximum(rings[..., 2], 1e-6)
    columns = np.floor(rings[..., 0] / z * intrinsics.fx + intrinsics.cx)
    rows = np.floor(rings[..., 1] / z * intrinsics.fy + intrinsics.cy)
    height, width = depth.shape
    inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
    inside &= rings[..., 2] > 0.0
    measured = depth[
        np.clip(rows, 0, height - 1).astype(np.intp), np.clip(columns, 0, width - 1).astype(np.intp)
    ].astype(np.float64)
    known = inside & (measured > 0.0)
    # Where the ray of that pixel meets the plane, against what was measured along it.
    facing = intrinsics.rays(columns + 0.5, rows + 0.5) @ normal
    above = measured * facing - float(normal @ point)  # towards the camera [m]
    # Noise of depth is noise along the normal as far as the ray goes along the normal.
    growth = (z / float(point[2])) ** 2
    tolerance = np.maximum(TOLERANCE, NOISY * sigma * growth * np.abs(facing))
    surface = known & (np.abs(above) <= tolerance)
    past = known & (above < -tolerance)
    return Surroundings(_extent(radii, surface, inside, known), _edge(radii, surface, past))


def _extent(
    radii: Points,
    surface: npt.NDArray[np.bool_],
    inside: npt.NDArray[np.bool_],
    known: npt.NDArray[np.bool_],
) -> float:
    """Return the radius before the first ring of which too much is not the surface.

    A place in the picture without depth is a hole of the sensor unless rings in a row have none in
    its direction: it does not count against the surface, nor for it.
    """
    other = ~surface & (known | ~inside)
    unknown = _in_a_row(inside & ~known)
    ended = (other.mean(axis=1) > MISSING_SHARE) | (unknown.mean(axis=1) > 3.0 * MISSING_SHARE)
    first = np.flatnonzero(ended)
    return float(radii[first[0]] - RING_STEP) if len(first) else float(radii[-1])


def _edge(radii: Points, surface: npt.NDArray[np.bool_], past: npt.NDArray[np.bool_]) -> float:
    """Return the distance up to which no direction sees past the surface."""
    runs = _in_a_row(past)
    nearest = LARGEST
    for direction in np.flatnonzero(runs.any(axis=0)):
        ended = int(np.argmax(runs[:, direction]))
        # Beside an edge depth is often unknown: the surface was last seen before that.
        before = np.flatnonzero(surface[:ended, direction])
        nearest = min(nearest, float(radii[before[-1]]) if len(before) else 0.0)
    return nearest


def _in_a_row(flags: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Return where flags (rings, directions) hold for some rings in a row, or up to the last."""
    runs = flags.copy()
    for shift in range(1, ENDED_RINGS):
        runs[:-shift] &= flags[shift:]
    return runs


def circle(normal: Vector) -> Points:
    """Return unit vectors (RING_POINTS, 3) all around a normal."""
    x, y, _ = frame_from_normal(normal).T
    return np.asarray(_COSINES * x + _SINES * y)
