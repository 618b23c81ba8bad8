"""From a pixel with depth to a point on a surface: a plane through what the hand would touch.

The plane is the one that most points inside the footprint agree on, among those through the chosen point;
points of another surface behind an edge have no say, so the answer is never the mean of two.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from w2c.errors import RefusedError
from w2c.geometry import Intrinsics, Matrix, Vector, apply

Depth = npt.NDArray[np.float32]
Points = npt.NDArray[np.float64]

SEED_WINDOW = 2
"""Half width of the window [px] in which a hole is bridged and the nearer side of an edge is found"""
EDGE_STEP = 0.012
"""Neighbouring depths that differ by more are different surfaces [m]"""
EDGE_SHARE = 0.2
"""A surface must fill so much of the window to be one: less is noise"""
_GRAZING = 6.0
"""Depth may change by so many pixel widths from one pixel to the next on one surface"""
MIN_POINTS = 12
HYPOTHESES = 120
PLANE_TOLERANCE = 0.002
"""Points this close to a plane agree with it [m]"""
ROUGHNESS_REACH = 0.012
"""What is further from the plane than this is another thing, not roughness [m]"""
EXTENT_TOLERANCE = 0.006
MAX_EXTENT = 0.25
_RING_STEP = 0.005
_RING_POINTS = 32
_MISSING_SHARE = 0.1
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


@dataclass(frozen=True)
class _Plane:
    """normal @ x = offset, in the camera frame; the normal looks at the camera."""

    normal: Vector
    offset: float
    spread: float
    """Root mean square distance of the points that agree [m]"""
    support: int

    def depth_at(self, rays: Points) -> Points:
        """Return the z-depth (n,) where rays (n, 3) with z = 1 meet the plane; infinity where they do not."""
        along = rays @ self.normal
        with np.errstate(divide="ignore"):
            depth = np.where(np.abs(along) > 1e-9, self.offset / along, np.inf)
        return np.where(depth > 0.0, depth, np.inf)


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
    row, column = _pixel(depth, u, v)
    row, column, seed_depth = _seed(depth, row, column, intrinsics.fx)
    moved = (column, row) != (int(u), int(v))
    seed_u, seed_v = (column + 0.5, row + 0.5) if moved else (u, v)
    seed = intrinsics.point_from_pixel(seed_u, seed_v, seed_depth)
    points = _neighbours(depth, intrinsics, row, column, seed, footprint)
    plane = _fit(points, seed, depth_unit)
    ray = seed / seed_depth
    plane_depth = float(plane.depth_at(ray[None])[0])
    # On a curved surface the plane cuts through: what was measured is the better point then.
    point = ray * plane_depth if abs(plane_depth - seed_depth) <= 2 * PLANE_TOLERANCE else seed
    distances = points @ plane.normal - plane.offset
    own = distances[np.abs(distances) <= ROUGHNESS_REACH]
    flatness = float(np.sqrt(np.mean(own**2)))
    extent = _extent(depth, intrinsics, plane, point)
    normal = world_from_camera[:3, :3] @ plane.normal
    slope = float(np.arccos(np.clip(normal[2], -1.0, 1.0)))
    error_bound = (
        0.5 * depth_unit
        + 3.0 * plane.spread / np.sqrt(max(plane.support, 1))
        + min(
            float(np.linalg.norm(ray)) * _misfit(depth, intrinsics, plane, row, column), footprint
        )
        + pose_error
        + (np.hypot(seed_u - u, seed_v - v) * seed_depth / intrinsics.fx if moved else 0.0)
    )
    return Surface(
        point=apply(world_from_camera, point),
        normal=normal,
        error_bound=float(error_bound),
        flatness=flatness,
        slope=slope,
        extent=extent,
        warning=_warning(extent, footprint, flatness, slope, moved),
    )


def _pixel(depth: Depth, u: float, v: float) -> tuple[int, int]:
    """Return the row and column of a pixel. Raises RefusedError outside of the picture."""
    height, width = depth.shape
    if not (np.isfinite(u) and np.isfinite(v) and 0.0 <= u < width and 0.0 <= v < height):
        raise RefusedError(
            f"pixel ({u:g}, {v:g}) is outside of the picture of {width}x{height} px; choose one inside"
        )
    return int(v), int(u)


def _seed(depth: Depth, row: int, column: int, focal: float) -> tuple[int, int, float]:
    """Return the pixel of the nearest surface at a pixel, and its depth [m].

    On a surface that is the pixel itself. At an edge it is the closest pixel of the surface in front; in a
    small hole the closest one beside it. Raises RefusedError where there is no depth.
    """
    top, left = max(0, row - SEED_WINDOW), max(0, column - SEED_WINDOW)
    window = depth[top : row + SEED_WINDOW + 1, left : column + SEED_WINDOW + 1]
    rows, columns = np.nonzero(window > 0.0)
    if len(rows) < EDGE_SHARE * window.size:
        raise RefusedError(
            f"no depth at pixel ({column}, {row}): sky, glass, or too far; choose a point on a surface"
        )
    depths = window[rows, columns].astype(np.float64)
    order = np.argsort(depths)
    steps = np.diff(depths[order])
    # Surfaces in front of one another: sorted depths with a jump in between. Far away even a floor makes
    # a step from pixel to pixel.
    edge = max(EDGE_STEP, _GRAZING * float(depths.min()) / focal)
    groups = np.split(order, np.nonzero(steps > edge)[0] + 1)
    large = [group for group in groups if len(group) >= EDGE_SHARE * window.size]
    front = large[0] if large else max(groups, key=len)
    away = np.hypot(rows[front] + top - row, columns[front] + left - column)
    chosen = front[int(np.argmin(away))]
    return int(rows[chosen] + top), int(columns[chosen] + left), float(depths[chosen])


def _misfit(depth: Depth, intrinsics: Intrinsics, plane: _Plane, row: int, column: int) -> float:
    """Return how far [m] the plane misses the depth of the pixel and of those beside it on its surface."""
    rows, columns = np.mgrid[row - 1 : row + 2, column - 1 : column + 2]
    inside = (rows >= 0) & (rows < depth.shape[0]) & (columns >= 0) & (columns < depth.shape[1])
    rows, columns = rows[inside], columns[inside]
    measured = depth[rows, columns].astype(np.float64)
    same = np.abs(measured - depth[row, column]) <= EDGE_STEP
    x = (columns[same] + 0.5 - intrinsics.cx) / intrinsics.fx
    y = (rows[same] + 0.5 - intrinsics.cy) / intrinsics.fy
    expected = plane.depth_at(np.column_stack([x, y, np.ones(len(x))]))
    return float(np.abs(expected - measured[same]).max())


def _neighbours(
    depth: Depth, intrinsics: Intrinsics, row: int, column: int, seed: Vector, footprint: float
) -> Points:
    """Return the points (n, 3) within the footprint of the seed, in the camera frame.

    Raises:
        RefusedError: fewer than a plane needs.
    """
    reach = max(3, int(np.ceil(footprint / seed[2] * intrinsics.fx)) + 1)
    top, left = max(0, row - reach), max(0, column - reach)
    window = depth[top : row + reach + 1, left : column + reach + 1]
    # A thousand points fix a plane as well as ten thousand.
    stride = max(1, window.shape[0] // 40)
    rows, columns = np.nonzero(window[::stride, ::stride] > 0.0)
    z = window[::stride, ::stride][rows, columns].astype(np.float64)
    u, v = columns * stride + left + 0.5, rows * stride + top + 0.5
    x, y = (u - intrinsics.cx) / intrinsics.fx * z, (v - intrinsics.cy) / intrinsics.fy * z
    points = np.column_stack([x, y, z])
    near = points[
        np.linalg.norm(points - seed, axis=1) <= max(footprint, 3 * seed[2] / intrinsics.fx)
    ]
    if len(near) < MIN_POINTS:
        raise RefusedError(
            f"only {len(near)} points with depth within {footprint * 100:.0f} cm of pixel "
            f"({column}, {row}), a plane needs {MIN_POINTS}; choose a larger surface or come closer"
        )
    return near


def _fit(points: Points, seed: Vector, depth_unit: float) -> _Plane:
    """Return the plane near the seed that most points agree on, refined by least squares over them."""
    rng = np.random.default_rng(0)  # fixed: the same picture gives the same answer
    tolerance = max(PLANE_TOLERANCE, 2.0 * depth_unit)
    pairs = rng.integers(len(points), size=(HYPOTHESES, 2))
    normals = np.cross(points[pairs[:, 0]] - seed, points[pairs[:, 1]] - seed)
    lengths = np.linalg.norm(normals, axis=1)
    normals = normals[lengths > 1e-9] / lengths[lengths > 1e-9, None]
    if len(normals) == 0:
        raise RefusedError("the points around the pixel lie on a line; choose a wider surface")
    distances = np.abs((points - seed) @ normals.T)  # (n, hypotheses)
    best = normals[int(np.argmax((distances <= tolerance).sum(axis=0)))]
    inliers = np.abs((points - seed) @ best) <= tolerance
    for _ in range(3):
        centre = points[inliers].mean(axis=0)
        best = np.linalg.svd(points[inliers] - centre, full_matrices=False)[2][2]
        distances = (points - centre) @ best
        agreeing = np.abs(distances) <= tolerance
        if agreeing.sum() < 3 or (agreeing == inliers).all():
            break
        inliers = agreeing
    # Towards the camera, which is the origin.
    normal = -best if best @ centre > 0.0 else best
    spread = float(np.sqrt(np.mean(((points[inliers] - centre) @ normal) ** 2)))
    return _Plane(normal, float(normal @ centre), spread, int(inliers.sum()))


def _extent(depth: Depth, intrinsics: Intrinsics, plane: _Plane, point: Vector) -> float:
    """Return the radius [m] up to which the plane is seen all around the point.

    Rings in the plane are projected into the picture; a ring ends the surface where more than a tenth of it
    is not at the plane's depth. What is outside of the picture, or hidden, counts as missing.
    """
    reference = (
        np.array([1.0, 0.0, 0.0]) if abs(plane.normal[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    )
    first = np.cross(plane.normal, reference)
    first /= np.linalg.norm(first)
    second = np.cross(plane.normal, first)
    angles = np.linspace(0.0, 2.0 * np.pi, _RING_POINTS, endpoint=False)
    circle = np.cos(angles)[:, None] * first + np.sin(angles)[:, None] * second  # (ring, 3)
    radii = np.arange(_RING_STEP, MAX_EXTENT + 1e-9, _RING_STEP)
    rings = point + radii[:, None, None] * circle  # (radii, ring, 3)
    z = np.maximum(rings[..., 2], 1e-6)
    columns = np.floor(rings[..., 0] / z * intrinsics.fx + intrinsics.cx).astype(int)
    rows = np.floor(rings[..., 1] / z * intrinsics.fy + intrinsics.cy).astype(int)
    height, width = depth.shape
    inside = (
        (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width) & (rings[..., 2] > 0.0)
    )
    measured = depth[np.clip(rows, 0, height - 1), np.clip(columns, 0, width - 1)]
    pixels = np.stack([columns + 0.5, rows + 0.5], axis=-1)
    rays = np.concatenate(
        [
            (pixels - [intrinsics.cx, intrinsics.cy]) / [intrinsics.fx, intrinsics.fy],
            np.ones((*z.shape, 1)),
        ],
        axis=-1,
    )
    away = np.abs((measured[..., None] * rays) @ plane.normal - plane.offset)
    missing = ~inside | (measured <= 0.0) | (away > EXTENT_TOLERANCE)
    ended = np.nonzero(missing.mean(axis=1) > _MISSING_SHARE)[0]
    return float(radii[ended[0]] - _RING_STEP) if len(ended) else float(radii[-1])


def _warning(extent: float, footprint: float, flatness: float, slope: float, moved: bool) -> str:
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
