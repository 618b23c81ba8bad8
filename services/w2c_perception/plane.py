"""Planes through depth: fitted to points of one surface, and followed as far as they are seen."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from w2c.errors import RefusedError
from w2c.geometry import Intrinsics, Vector, unit

Depth = npt.NDArray[np.float32]
Points = npt.NDArray[np.float64]

TOLERANCE = 0.002
"""Points this close to a plane agree with it [m]"""
HYPOTHESES = 80
SEED_BONUS = 1.2
"""A plane through the chosen point wins over another that a few more points agree with"""
EXTENT_TOLERANCE = 0.006
"""Depth this far from the plane is another surface [m]"""
MAX_EXTENT = 0.25
"""Nobody asks how large a surface is beyond this [m]"""
RING_STEP = 0.005
RING_POINTS = 32
MISSING_SHARE = 0.1


@dataclass(frozen=True)
class Plane:
    """normal @ x = offset, in the camera frame; the normal looks at the camera."""

    normal: Vector
    offset: float
    spread: float
    """Root mean square distance of the points that agree [m]"""
    support: int
    """How many points agree"""

    def depth_at(self, rays: Points) -> Points:
        """Return z-depths (n,) of rays (n, 3) with z = 1 on the plane; infinity where they miss."""
        along = rays @ self.normal
        with np.errstate(divide="ignore"):
            depth = np.where(np.abs(along) > 1e-9, self.offset / along, np.inf)
        return np.asarray(np.where(depth > 0.0, depth, np.inf), dtype=np.float64)

    def distances(self, points: Points) -> Points:
        """Return the signed distances (n,) of points (n, 3) [m], positive towards the camera."""
        return np.asarray(points @ self.normal - self.offset, dtype=np.float64)


def rays(intrinsics: Intrinsics, rows: Points, columns: Points) -> Points:
    """Return the rays (..., 3) with z = 1 through the centres of pixels."""
    x = (columns + 0.5 - intrinsics.cx) / intrinsics.fx
    y = (rows + 0.5 - intrinsics.cy) / intrinsics.fy
    return np.stack([x, y, np.ones_like(x)], axis=-1)


def fit(points: Points, seed: Vector, depth_unit: float) -> Plane:
    """Return the plane near the seed that most points agree on, by least squares over those.

    Random sample consensus over planes through the seed, then refined; the draws are fixed, so
    that the same picture gives the same answer.

    Args:
        points: (n, 3) in the camera frame [m].
        seed: (3,) the point that was chosen [m].
        depth_unit: smallest step of the depth [m].

    Raises:
        RefusedError: all points lie on a line.
    """
    tolerance = max(TOLERANCE, 2.0 * depth_unit)
    inliers = _consensus(points, seed, tolerance)
    for _ in range(3):
        centre = points[inliers].mean(axis=0)
        normal = np.linalg.svd(points[inliers] - centre, full_matrices=False)[2][2]
        agreeing = np.abs((points - centre) @ normal) <= tolerance
        if agreeing.sum() < 3 or (agreeing == inliers).all():
            break
        inliers = agreeing
    if normal @ centre > 0.0:  # the camera is the origin
        normal = -normal
    spread = float(np.sqrt(np.mean(((points[inliers] - centre) @ normal) ** 2)))
    return Plane(normal, float(normal @ centre), spread, int(inliers.sum()))


def _consensus(points: Points, seed: Vector, tolerance: float) -> npt.NDArray[np.bool_]:
    """Return which points (n,) agree with the plane that most of them agree with.

    Half of the candidates go through the seed and two points, for where its surface is a small
    part of what is around; half through three points that pass close to the seed, for where it is
    itself noisy.

    Raises:
        RefusedError: all points lie on a line.
    """
    rng = np.random.default_rng(0)
    draws = rng.integers(len(points), size=(2 * HYPOTHESES, 3))
    anchors = points[draws[:, 0]]
    anchors[:HYPOTHESES] = seed
    normals = np.cross(points[draws[:, 1]] - anchors, points[draws[:, 2]] - anchors)
    lengths = np.linalg.norm(normals, axis=1)
    normals = normals / np.maximum(lengths, 1e-12)[:, None]
    offsets = np.einsum("ij,ij->i", normals, anchors)
    possible = (lengths > 1e-9) & (np.abs(normals @ seed - offsets) <= 2.0 * tolerance)
    if not possible.any():
        raise RefusedError("the points around the pixel lie on a line; choose a wider surface")
    agreement = np.abs(points @ normals.T - offsets) <= tolerance  # (n, 2 hypotheses)
    votes = np.where(possible, agreement.sum(axis=0), -1).astype(np.float64)
    votes[:HYPOTHESES] *= SEED_BONUS
    return np.asarray(agreement[:, int(np.argmax(votes))])


def extent(depth: Depth, intrinsics: Intrinsics, plane: Plane, point: Vector) -> float:
    """Return the radius [m] up to which the plane is seen all around a point of it.

    Rings in the plane are projected into the picture; a ring ends the surface where more than a
    tenth of it is not at the plane's depth. What is outside of the picture, or hidden, counts as
    missing.
    """
    radii = np.arange(RING_STEP, MAX_EXTENT + 1e-9, RING_STEP)
    rings = point + radii[:, None, None] * _circle(plane.normal)  # (radii, ring, 3)
    z = np.maximum(rings[..., 2], 1e-6)
    columns = np.floor(rings[..., 0] / z * intrinsics.fx + intrinsics.cx)
    rows = np.floor(rings[..., 1] / z * intrinsics.fy + intrinsics.cy)
    height, width = depth.shape
    inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
    inside &= rings[..., 2] > 0.0
    row_index = np.clip(rows, 0, height - 1).astype(int)
    column_index = np.clip(columns, 0, width - 1).astype(int)
    measured = depth[row_index, column_index]
    seen = measured[..., None] * rays(intrinsics, rows, columns)
    away = np.abs(plane.distances(seen.reshape(-1, 3))).reshape(measured.shape)
    missing = ~inside | (measured <= 0.0) | (away > EXTENT_TOLERANCE)
    ended = np.nonzero(missing.mean(axis=1) > MISSING_SHARE)[0]
    return float(radii[ended[0]] - RING_STEP) if len(ended) else float(radii[-1])


def _circle(normal: Vector) -> Points:
    """Return unit vectors (ring, 3) all around a normal."""
    reference = np.array([1.0, 0.0, 0.0]) if abs(normal[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    first = unit(np.cross(normal, reference))
    second = np.cross(normal, first)
    angles = np.linspace(0.0, 2.0 * np.pi, RING_POINTS, endpoint=False)
    return np.asarray(np.cos(angles)[:, None] * first + np.sin(angles)[:, None] * second)
