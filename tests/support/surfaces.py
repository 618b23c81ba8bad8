"""Made-up depth: what a camera that looks 45 degrees down sees of planes, boxes, balls and rods."""

import numpy as np
import numpy.typing as npt

from w2c.geometry import Intrinsics, Matrix, Vector, transform, unit
from w2c.messages import Array

Depth = npt.NDArray[np.float32]

WIDTH, HEIGHT = 320, 240
CAMERA = Intrinsics(300.0, 300.0, 160.0, 120.0)
# Camera axes in the world: looks along +x and 45 degrees down; x right = -y, y down.
DOWN = np.sqrt(0.5)
WORLD_FROM_CAMERA: Matrix = transform(
    np.column_stack([[0, -1, 0], [-DOWN, 0, -DOWN], [DOWN, 0, -DOWN]]), [0.0, 0.0, 1.6]
)


def all_rays() -> Vector:
    """Return the ray (h, w, 3) of every pixel, in the camera frame, z = 1."""
    rows, columns = np.mgrid[0:HEIGHT, 0:WIDTH].astype(float)
    return CAMERA.rays(columns + 0.5, rows + 0.5)


def depth_of(normal: Vector, point: Vector) -> Vector:
    """Return the depth (h, w) of a plane given in the world; infinite where it is not seen."""
    n = WORLD_FROM_CAMERA[:3, :3].T @ unit(normal)
    offset = n @ (WORLD_FROM_CAMERA[:3, :3].T @ (np.asarray(point) - WORLD_FROM_CAMERA[:3, 3]))
    along = all_rays() @ n
    with np.errstate(divide="ignore"):
        depth = offset / along
    return np.where(depth > 0, depth, np.inf)


def in_world(u: float, v: float, depth: float) -> Vector:
    """Return the world point of a pixel at a depth."""
    point = CAMERA.point_from_pixel(u, v, depth)
    return WORLD_FROM_CAMERA[:3, :3] @ point + WORLD_FROM_CAMERA[:3, 3]


def quantised(depth: Vector) -> Depth:
    """Return depth as it comes off the wire."""
    known = np.where(np.isfinite(depth) & (depth < 16.0), depth, 0.0)
    return (np.rint(known / 0.00025) * 0.00025).astype(np.float32)


TABLE_HEIGHT = 0.8
TABLE = depth_of(np.array([0, 0, 1.0]), np.array([0, 0, TABLE_HEIGHT]))


def book(height: float = 0.04) -> tuple[Depth, Array]:
    """Return depth of a box on the table, and which pixels show its top (h, w)."""
    top = depth_of(np.array([0, 0, 1.0]), np.array([0, 0, TABLE_HEIGHT + height]))
    points = all_rays() * np.where(np.isfinite(top), top, 0.0)[..., None]
    world = points @ WORLD_FROM_CAMERA[:3, :3].T + WORLD_FROM_CAMERA[:3, 3]
    inside = (np.abs(world[..., 0] - 0.8) < 0.12) & (np.abs(world[..., 1]) < 0.1)
    return quantised(np.where(inside, top, TABLE)), inside


def ball(centre: Vector, radius: float) -> Vector:
    """Return the depth (h, w) of a ball given in the camera frame; infinite beside it."""
    along = all_rays()
    a = (along**2).sum(axis=-1)
    b = along @ np.asarray(centre)
    under_root = b**2 - a * (np.dot(centre, centre) - radius**2)
    return np.where(under_root > 0, (b - np.sqrt(np.maximum(under_root, 0))) / a, np.inf)


def upright_rod(u: float, width: float, depth: float) -> Vector:
    """Return the depth (h, w) of a flat rod from top to bottom, `width` px wide about column u."""
    columns = np.mgrid[0:HEIGHT, 0:WIDTH][1] + 0.5
    return np.where(np.abs(columns - u) <= 0.5 * width, depth, np.inf)


def noisy(depth: Vector, sigma: float, seed: int = 0) -> Depth:
    """Return depth as it comes off the wire, with normal noise [m]."""
    return quantised(depth + np.random.default_rng(seed).normal(0.0, sigma, depth.shape))
