"""Colours and depth that were taken at two instants, by a camera that moved between them.

A pixel is chosen in the colours. What it shows is looked for in the depth picture along the pixel's
ray: from near to far, the first place where the ray meets a surface that depth saw. Whatever moved
by itself meanwhile is not known.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from w2c.errors import RefusedError
from w2c.geometry import Intrinsics, Matrix, Vector, apply
from w2c_perception.window import EDGE_NOISE, EDGE_STEP, GRAZING, USUAL_NOISE, DepthPicture, Points

NEAREST, FARTHEST = 0.2, 16.0
"""Where on a ray a surface is looked for, z-depth in the colours' camera [m]"""
STEP = 0.7
"""Between two places that are looked at [px of the depth picture]"""
MOST = 2000
"""Such places"""
SMALL = 0.1
"""A ray that the other camera sees within so much is a point to it [px]"""
ROUNDS = 3
"""So many times the depth of a cell is looked up, each where the former puts it"""


@dataclass(frozen=True)
class Match:
    """Where depth shows what a pixel of the colours shows."""

    u: float
    v: float
    """In the depth picture [px]"""
    hidden: float
    """Length of the ray before that place that depth could not see: something may be there that
    only the colours show [m]"""


def find_in_depth(
    depth: DepthPicture, intrinsics: Intrinsics, depth_from_colours: Matrix, u: float, v: float
) -> Match:
    """Return where in a depth picture the thing is that a pixel of the colours shows.

    Args:
        depth: (h, w) z-depth [m], 0 = unknown.
        intrinsics: of both pictures.
        depth_from_colours: (4, 4) from the camera when it took the colours to when it took depth.
        u: to the right, in the colours [px].
        v: down [px].

    Raises:
        RefusedError: depth did not see it.
    """
    unseen = RefusedError(
        f"depth of another instant than the picture's does not show what is at pixel ({u:.0f}, "
        f"{v:.0f}); choose the pixel in a picture that was taken at rest"
    )
    ray = depth_from_colours[:3, :3] @ intrinsics.point_from_pixel(u, v, 1.0)
    # p / z = ray + origin / z: steps that are even in inverse depth are even in the picture.
    ends = ray + np.array([[1.0 / NEAREST], [1.0 / FARTHEST]]) * depth_from_colours[:3, 3]
    if (ends[:, 2] <= 0.0).any():
        raise unseen
    length = float(np.linalg.norm(np.diff(pixels_of(intrinsics, ends), axis=0)))
    if length < SMALL:
        column, row = pixels_of(intrinsics, ends)[0]
        return Match(float(column), float(row), 0.0)
    inverse = np.linspace(1.0 / NEAREST, 1.0 / FARTHEST, min(MOST, int(length / STEP) + 2))
    points = ray / inverse[:, None] + depth_from_colours[:3, 3]
    measured = _look_up(depth, pixels_of(intrinsics, points))
    known = measured > 0.0
    match = _first_surface(intrinsics, points[known], measured[known])
    if match is None:
        raise unseen
    return match


def to_colours(
    cells: npt.NDArray[np.uint8],
    depth: DepthPicture,
    intrinsics: Intrinsics,
    depth_from_colours: Matrix,
    side: int,
    unseen: int,
) -> npt.NDArray[np.uint8]:
    """Return a grid of codes of the depth picture as one of the colours.

    Args:
        cells: (rows, columns) of the depth picture.
        depth: (h, w) z-depth [m], 0 = unknown.
        intrinsics: of both pictures.
        depth_from_colours: (4, 4).
        side: of a cell [px].
        unseen: code of what depth did not see.
    """
    rows, columns = np.mgrid[0 : cells.shape[0], 0 : cells.shape[1]]
    u, v = ((axis.ravel() + 0.5) * side for axis in (columns, rows))
    rays = intrinsics.rays(u, v)
    z = _look_up(depth, np.stack([u, v], axis=-1))
    typical = float(np.median(z[z > 0.0])) if (z > 0.0).any() else 1.0
    for _ in range(ROUNDS):
        points = apply(depth_from_colours, np.where(z > 0.0, z, typical)[:, None] * rays)
        pixels = pixels_of(intrinsics, points)
        z = _look_up(depth, pixels)
    inside = within(pixels, depth)
    column, row = (np.where(inside, axis, 0.0).astype(np.intp) // side for axis in pixels.T)
    return np.where(inside, cells[row, column], unseen).reshape(cells.shape).astype(np.uint8)


def pixels_of(intrinsics: Intrinsics, points: Points) -> Points:
    """Return the pixels (n, 2) of points (n, 3) before the camera; of those behind it, -1."""
    z = np.where(points[:, 2] > 0.0, points[:, 2], 1.0)
    focal, centre = np.array(intrinsics[:2]), np.array(intrinsics[2:])
    pixels = points[:, :2] / z[:, None] * focal + centre
    return np.where(points[:, 2:] > 0.0, pixels, -1.0)


def within(pixels: Points, depth: DepthPicture) -> npt.NDArray[np.bool_]:
    """Tell which pixels (n, 2) are in a picture (h, w)."""
    height, width = depth.shape
    return np.asarray(((pixels >= 0.0) & (pixels < (width, height))).all(axis=1))


def _look_up(depth: DepthPicture, pixels: Points) -> Vector:
    """Return what was measured at pixels (n, 2) [m]; 0 = unknown, or outside of the picture."""
    inside = within(pixels, depth)
    columns, rows = np.where(inside[:, None], pixels, 0.0).astype(np.intp).T
    return np.where(inside, depth[rows, columns], 0.0).astype(np.float64)


def _first_surface(intrinsics: Intrinsics, points: Points, measured: Vector) -> Match | None:
    """Return where a ray meets the first surface, None where it meets none that was seen.

    Args:
        intrinsics: of the depth picture.
        points: (n, 3) of the ray, near to far, in the depth's camera [m].
        measured: (n,) z-depth where each is seen [m].
    """
    before = np.asarray(measured > points[:, 2])  # the point is before what depth saw there
    # Where depth jumps the ray does not meet a surface: it goes on behind one.
    sigma = USUAL_NOISE[0] + USUAL_NOISE[1] * measured[:-1] ** 2
    slack = np.maximum(EDGE_STEP, EDGE_NOISE * sigma)
    slack = np.maximum(slack, GRAZING * measured[:-1] / intrinsics.fx)
    joined = np.abs(np.diff(measured)) <= slack
    met = np.flatnonzero(before[:-1] & ~before[1:] & joined)
    if not len(met):
        return None
    first = int(met[0])
    above, below = (measured[k] - points[k, 2] for k in (first, first + 1))
    share = float(above / (above - below))
    point = (1.0 - share) * points[first] + share * points[first + 1]
    lengths = np.linalg.norm(np.diff(points[: first + 1], axis=0), axis=1)
    hidden = float(lengths[~before[:first] | ~before[1 : first + 1]].sum())
    u, v = intrinsics.pixel_from_point(point)
    return Match(float(u), float(v), hidden)
