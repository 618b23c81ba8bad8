"""From a pixel with depth to a point on a surface: a plane through what the hand would touch.

The plane is the one that most points inside the footprint agree on, among those through the chosen
point; points of another surface behind an edge have no say: the answer is never the mean of two.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from w2c.errors import RefusedError
from w2c.geometry import Intrinsics, Matrix, Vector, apply
from w2c_perception import plane as planes
from w2c_perception.plane import Depth, Plane, Points

SEED_WINDOW = 2
"""Half width of the window [px] that bridges a hole and finds the nearer side of an edge"""
EDGE_STEP = 0.012
"""Neighbouring depths that differ by more are different surfaces [m]"""
GRAZING = 6.0
"""On one surface depth may change by so many pixel widths from one pixel to the next"""
EDGE_SHARE = 0.2
"""A surface must fill so much of the window to be one: less is noise"""
MIN_POINTS = 12
MAX_MISFIT = 2 * planes.TOLERANCE
"""Where the plane misses the chosen pixel by more, the surface is curved: the pixel is right [m]"""
ROUGHNESS_REACH = 0.012
"""What is further from the plane than this is another thing, not roughness [m]"""
ROUGH = 0.004
STEEP = np.radians(30.0)


@dataclass(frozen=True)
class Surface:
    """What is known around a point, in the world."""

    point: Vector
    """(3,) [m]"""
    normal: Vector
    """(3,) unit, towards the camera"""
    error_bound: float
    """[m]"""
    flatness: float
    """Root mean square distance to the plane inside the footprint [m]"""
    slope: float
    """Between normal and vertical [rad]"""
    extent: float
    """Radius of the flat surface around the point [m]"""
    warning: str


class _Seed(NamedTuple):
    """The pixel whose surface is meant."""

    row: int
    column: int
    u: float
    v: float
    depth: float
    moved: float
    """How far from the pixel that was asked for [px]; 0 = it is that pixel"""


def lift(
    depth: Depth,
    intrinsics: Intrinsics,
    world_from_camera: Matrix,
    u: float,
    v: float,
    *,
    footprint: float = 0.03,
    depth_unit: float = 0.00025,
    pose_error: float = 0.0,
) -> Surface:
    """Return the surface behind a pixel.

    Args:
        depth: (h, w) z-depth [m], 0 = unknown.
        intrinsics: of the camera.
        world_from_camera: (4, 4) when the picture was taken.
        u: to the right [px].
        v: down [px].
        footprint: radius of what will touch the surface [m].
        depth_unit: smallest step of the depth [m].
        pose_error: how far off the camera itself may be [m].

    Raises:
        RefusedError: outside of the picture, no depth there, or too few points around it.
    """
    seed = _seed(depth, intrinsics, u, v)
    seed_point = intrinsics.point_from_pixel(seed.u, seed.v, seed.depth)
    ray = seed_point / seed.depth
    points = _neighbours(depth, intrinsics, seed, seed_point, footprint)
    plane = planes.fit(points, seed_point, depth_unit)
    plane_depth = float(plane.depth_at(ray[None])[0])
    # On a curved surface the plane cuts through: what was measured is the better point then.
    point = ray * plane_depth if abs(plane_depth - seed.depth) <= MAX_MISFIT else seed_point
    distances = plane.distances(points)
    own = distances[np.abs(distances) <= ROUGHNESS_REACH]
    flatness = float(np.sqrt(np.mean(own**2)))
    extent = planes.extent(depth, intrinsics, plane, point)
    normal = world_from_camera[:3, :3] @ plane.normal
    slope = float(np.arccos(np.clip(normal[2], -1.0, 1.0)))
    misfit = float(np.linalg.norm(ray)) * _misfit(depth, intrinsics, plane, seed)
    error_bound = (
        0.5 * depth_unit
        + 3.0 * plane.spread / np.sqrt(max(plane.support, 1))
        + min(misfit, footprint)
        + seed.moved * seed.depth / intrinsics.fx
        + pose_error
    )
    return Surface(
        point=apply(world_from_camera, point),
        normal=normal,
        error_bound=float(error_bound),
        flatness=flatness,
        slope=slope,
        extent=extent,
        warning=_warning(extent, footprint, flatness, slope, moved=seed.moved > 0.0),
    )


def _seed(depth: Depth, intrinsics: Intrinsics, u: float, v: float) -> _Seed:
    """Return the pixel of the nearest surface at (u, v).

    On a surface that is the pixel itself. At an edge it is the closest pixel of the surface in
    front, in a small hole the closest one beside it.

    Raises:
        RefusedError: outside of the picture, or no depth there.
    """
    height, width = depth.shape
    if not (np.isfinite(u) and np.isfinite(v) and 0.0 <= u < width and 0.0 <= v < height):
        raise RefusedError(
            f"pixel ({u:g}, {v:g}) is outside of the picture, {width}x{height} px; choose one in it"
        )
    row, column = int(v), int(u)
    top, left = max(0, row - SEED_WINDOW), max(0, column - SEED_WINDOW)
    window = depth[top : row + SEED_WINDOW + 1, left : column + SEED_WINDOW + 1]
    rows, columns = np.nonzero(window > 0.0)
    if len(rows) < EDGE_SHARE * window.size:
        raise RefusedError(
            f"no depth at pixel ({column}, {row}): sky, glass, or too far; choose a surface"
        )
    front = _front_group(window[rows, columns].astype(np.float64), window.size, intrinsics.fx)
    away = np.hypot(rows[front] + top - row, columns[front] + left - column)
    nearest = int(np.argmin(away))
    chosen_row, chosen_column = int(rows[front[nearest]] + top), int(columns[front[nearest]] + left)
    chosen_depth = float(depth[chosen_row, chosen_column])
    if away[nearest] == 0.0:
        return _Seed(row, column, u, v, chosen_depth, 0.0)
    centre_u, centre_v = chosen_column + 0.5, chosen_row + 0.5
    moved = float(np.hypot(centre_u - u, centre_v - v))
    return _Seed(chosen_row, chosen_column, centre_u, centre_v, chosen_depth, moved)


def _front_group(depths: Points, window_size: int, focal: float) -> list[int]:
    """Return which of the depths (n,) belong to the surface in front: sorted, up to a jump."""
    order = np.argsort(depths)
    # Far away even a floor makes a step from pixel to pixel.
    edge = max(EDGE_STEP, GRAZING * float(depths.min()) / focal)
    groups = np.split(order, np.nonzero(np.diff(depths[order]) > edge)[0] + 1)
    large = [group for group in groups if len(group) >= EDGE_SHARE * window_size]
    front = large[0] if large else max(groups, key=len)
    return [int(index) for index in front]


def _misfit(depth: Depth, intrinsics: Intrinsics, plane: Plane, seed: _Seed) -> float:
    """Return how far [m] the plane misses the depth of the pixel and of those beside it."""
    rows, columns = np.mgrid[seed.row - 1 : seed.row + 2, seed.column - 1 : seed.column + 2]
    inside = (rows >= 0) & (rows < depth.shape[0]) & (columns >= 0) & (columns < depth.shape[1])
    rows, columns = rows[inside], columns[inside]
    measured = depth[rows, columns].astype(np.float64)
    same = np.abs(measured - depth[seed.row, seed.column]) <= EDGE_STEP
    expected = plane.depth_at(planes.rays(intrinsics, rows[same], columns[same]))
    return float(np.abs(expected - measured[same]).max())


def _neighbours(
    depth: Depth, intrinsics: Intrinsics, seed: _Seed, seed_point: Vector, footprint: float
) -> Points:
    """Return the points (n, 3) within the footprint of the seed, in the camera frame.

    Raises:
        RefusedError: fewer than a plane needs.
    """
    reach = max(3, int(np.ceil(footprint / seed.depth * intrinsics.fx)) + 1)
    top, left = max(0, seed.row - reach), max(0, seed.column - reach)
    window = depth[top : seed.row + reach + 1, left : seed.column + reach + 1]
    stride = max(1, window.shape[0] // 40)  # a thousand points fix a plane as well as more
    rows, columns = np.nonzero(window[::stride, ::stride] > 0.0)
    z = window[::stride, ::stride][rows, columns].astype(np.float64)
    points = z[:, None] * planes.rays(intrinsics, rows * stride + top, columns * stride + left)
    radius = max(footprint, 3 * seed.depth / intrinsics.fx)
    near = points[np.linalg.norm(points - seed_point, axis=1) <= radius]
    if len(near) < MIN_POINTS:
        raise RefusedError(
            f"only {len(near)} points with depth within {radius * 100:.1f} cm of pixel "
            f"({seed.column}, {seed.row}), a plane needs {MIN_POINTS}; "
            "choose a larger surface or come closer"
        )
    return np.asarray(near, dtype=np.float64)


def _warning(extent: float, footprint: float, flatness: float, slope: float, *, moved: bool) -> str:
    """Return what an operator should know, or nothing."""
    remarks = []
    if extent < footprint:
        remarks.append(f"near an edge: {extent * 100:.1f} cm of flat surface around the point")
    if flatness > ROUGH:
        remarks.append(f"not flat: {flatness * 1000:.0f} mm")
    if slope > STEEP:
        remarks.append(f"steep: {np.degrees(slope):.0f} degrees")
    if moved:
        remarks.append("moved to the nearest surface in front")
    return "; ".join(remarks)
