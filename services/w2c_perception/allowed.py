"""Where in a whole picture a hand may go: flat x large enough x slope, cell by cell.

Planes are fitted to the inverse depth in a window around every cell, as large as the hand is there,
by sums over integral images: the time does not depend on the size of the windows.
"""

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from w2c.geometry import Intrinsics, Matrix, apply
from w2c_perception.fitness import Demands
from w2c_perception.heights import on_arms
from w2c_perception.patch import Points
from w2c_perception.window import USUAL_NOISE, DepthPicture

SAMPLE_STEP = 4
"""Every so many pixels depth is read [px]"""
CELL_STEP = 2
"""Samples from cell to cell"""
CELL = SAMPLE_STEP * CELL_STEP
"""Side of a cell [px]"""
BRIDGE = 5
"""Samples across in which holes are filled"""
MOSTLY = 0.5
"""Of what is around a hole must be seen: at the end of a surface less is"""
KNOWN_SHARE = 0.6
"""Of a window that must have depth"""
GOOD_SHARE = 0.96
"""Of the flat samples in a window that is large enough"""
WALL = np.radians(65.0)
"""Steeper is a wall: it carries no weight, but a hand can push against it"""
NOISE_SLACK = 2.0
"""Times the noise that it is uneven by anyway"""

ALLOWED, UNSEEN, ARM, UNEVEN, STEEP, SMALL = range(6)
REASONS = (
    "no depth",
    "the robot's own arm",
    "not flat",
    "too steep",
    "too small or near an edge",
)
"""Of codes from 1 on"""


@dataclass(frozen=True)
class _Planes:
    """A plane through the window around each of (rows, columns) samples."""

    normals: Points
    """(rows, columns, 3) towards the camera, in the camera frame"""
    misfit: Points
    """Root mean square distance from the plane [m]"""
    known: npt.NDArray[np.bool_]


def allowed_cells(
    depth: DepthPicture,
    intrinsics: Intrinsics,
    world_from_camera: Matrix,
    arms: Points,
    demands: Demands | None = None,
    *,
    walls: bool = True,
) -> npt.NDArray[np.uint8]:
    """Return a code for each cell (rows, columns): 0 allowed, k forbidden by `REASONS[k - 1]`.

    A cell is `CELL` pixels wide and high; the last ones are cut by the picture's border.

    Args:
        depth: (h, w) z-depth [m], 0 = unknown.
        intrinsics: of the picture.
        world_from_camera: (4, 4).
        arms: (n, 2, 3) the bones of the robot's arms, in the world [m].
        demands: on the surface.
        walls: whether surfaces that only a push can use are allowed.
    """
    demands = demands or Demands()
    half = SAMPLE_STEP // 2
    z = depth[half::SAMPLE_STEP, half::SAMPLE_STEP].astype(np.float64)
    rows, columns = np.mgrid[0 : z.shape[0], 0 : z.shape[1]]
    along = intrinsics.rays(columns * SAMPLE_STEP + half + 0.5, rows * SAMPLE_STEP + half + 0.5)
    seen = z > 0.0
    safe, near_seen = _bridged(z, seen)
    radius = demands.radius * intrinsics.fx / (safe * SAMPLE_STEP)
    planes = _fit_planes(z, seen, along, radius)
    sigma = _noise(depth) * (USUAL_NOISE[0] + USUAL_NOISE[1] * safe**2)
    limit = np.sqrt(demands.roughness**2 + (NOISE_SLACK * sigma) ** 2)
    known = planes.known & near_seen
    flat = known & (planes.misfit <= limit)
    up = planes.normals @ world_from_camera[2, :3]
    level = up >= np.cos(demands.steepest)
    if walls:
        level |= np.abs(up) <= np.cos(WALL)
    points = apply(world_from_camera, (safe[..., None] * along).reshape(-1, 3))
    arm = on_arms(points, arms).reshape(z.shape) & near_seen
    good = flat & level & ~arm
    # What is flat is so for the hand's radius around: the margin is beyond that.
    beyond = demands.margin / demands.radius
    large = good & _all_around(good, known, planes.normals, radius * beyond)
    # What is not seen may be where the surface ends.
    everywhere = np.ones_like(near_seen)
    large &= _all_around(near_seen, everywhere, planes.normals, radius * (1.0 + beyond))
    codes = np.select(
        [arm, ~known, ~flat, ~level, ~large], [ARM, UNSEEN, UNEVEN, STEEP, SMALL], ALLOWED
    )
    return np.asarray(codes[::CELL_STEP, ::CELL_STEP], dtype=np.uint8)


def _bridged(z: Points, seen: npt.NDArray[np.bool_]) -> tuple[Points, npt.NDArray[np.bool_]]:
    """Return depth with small holes filled from beside them, and where there is any nearby."""
    size = (BRIDGE, BRIDGE)
    share = np.asarray(cv2.blur(seen.astype(np.float64), size))
    mean = np.asarray(cv2.blur(np.where(seen, z, 0.0), size)) / np.maximum(share, 1e-9)
    near = share >= MOSTLY
    return np.where(seen, z, np.where(near, mean, 1.0)), near


def _noise(depth: DepthPicture) -> float:
    """Return the noise of a picture over that of usual cameras."""
    z = depth[::SAMPLE_STEP].astype(np.float64)
    left, middle, right = z[:, :-2:7], z[:, 1:-1:7], z[:, 2::7]
    known = (left > 0.0) & (middle > 0.0) & (right > 0.0)
    if not known.any():
        return 1.0
    bend = np.abs(left - 2.0 * middle + right)[known]
    usual = USUAL_NOISE[0] + USUAL_NOISE[1] * middle[known] ** 2
    return float(np.median(bend / usual)) / 0.6745 / float(np.sqrt(6.0))


def _fit_planes(
    z: Points,
    seen: npt.NDArray[np.bool_],
    along: Points,
    radius: Points,
) -> _Planes:
    """Return the planes of least squares through inverse depth, in windows of a radius (samples).

    1 / z = g . r along a ray r, see `patch`: with x and y of the ray as coordinates, the plane's
    coefficients are g itself.
    """
    inverse = np.where(seen, 1.0 / np.where(seen, z, 1.0), 0.0)
    x, y, weight = along[..., 0], along[..., 1], seen.astype(np.float64)
    terms = (
        weight, weight * x, weight * y, weight * x * x, weight * x * y, weight * y * y,
        inverse, inverse * x, inverse * y, inverse * inverse,
    )  # fmt: skip
    sums, area = _window_sums(np.stack(terms), radius, radius)
    count = np.maximum(sums[0], 1.0)
    mean_x, mean_y, mean = sums[1] / count, sums[2] / count, sums[6] / count
    xx = sums[3] / count - mean_x**2
    xy = sums[4] / count - mean_x * mean_y
    yy = sums[5] / count - mean_y**2
    xw = sums[7] / count - mean_x * mean
    yw = sums[8] / count - mean_y * mean
    determinant = xx * yy - xy * xy
    spread_out = determinant > 1e-3 * (xx + yy) ** 2
    safe = np.where(spread_out, determinant, 1.0)
    g_x, g_y = (yy * xw - xy * yw) / safe, (xx * yw - xy * xw) / safe
    g_z = mean - g_x * mean_x - g_y * mean_y
    square = sums[9] / count - mean**2 - g_x * xw - g_y * yw
    length = np.maximum(np.sqrt(g_x**2 + g_y**2 + g_z**2), 1e-9)
    # An error e of 1 / z is one of e z / |g| along the normal: g . (z r) = 1 on the plane.
    misfit = np.sqrt(np.maximum(square, 0.0)) / np.maximum(mean, 1e-9) / length
    known = spread_out & (sums[0] >= KNOWN_SHARE * area)
    normals = -np.stack([g_x, g_y, g_z], axis=-1) / length[..., None]
    return _Planes(normals, misfit, known)


def _all_around(
    good: npt.NDArray[np.bool_], known: npt.NDArray[np.bool_], normals: Points, radius: Points
) -> npt.NDArray[np.bool_]:
    """Tell around which samples the known ones are good within a radius (samples) on the surface.

    A disc seen at an angle is an ellipse in the picture, with half axes by its normal.
    """
    across = radius * np.sqrt(np.maximum(0.0, 1.0 - normals[..., 0] ** 2))
    down = radius * np.sqrt(np.maximum(0.0, 1.0 - normals[..., 1] ** 2))
    layers = np.stack([good, known]).astype(np.float64)
    sums, area = _window_sums(layers, across, down)
    enough = sums[1] >= KNOWN_SHARE * area
    return np.asarray(enough & (sums[0] >= GOOD_SHARE * sums[1]))


def _window_sums(layers: Points, across: Points, down: Points) -> tuple[Points, Points]:
    """Return sums (n, rows, columns) over windows around each sample, and their full areas.

    Args:
        layers: (n, rows, columns).
        across: (rows, columns) half widths [samples].
        down: (rows, columns) half heights [samples].
    """
    height, width = layers.shape[1:]
    rows, columns = np.mgrid[0:height, 0:width]
    half_w = np.maximum(1, np.rint(across)).astype(np.intp)
    half_h = np.maximum(1, np.rint(down)).astype(np.intp)
    left, right = np.maximum(0, columns - half_w), np.minimum(width, columns + half_w + 1)
    top, bottom = np.maximum(0, rows - half_h), np.minimum(height, rows + half_h + 1)
    stride = width + 1
    corners = (bottom * stride + right, top * stride + left, bottom * stride + left,
               top * stride + right)  # fmt: skip
    results = np.empty_like(layers)
    for layer, result in zip(layers, results, strict=True):
        table = np.asarray(cv2.integral(layer)).ravel()
        plus = table.take(corners[0]) + table.take(corners[1])
        result[:] = plus - table.take(corners[2]) - table.take(corners[3])
    return results, (2.0 * half_w + 1.0) * (2.0 * half_h + 1.0)
