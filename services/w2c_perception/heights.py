"""From a depth picture to heights over the floor: what a hand must clear on its way."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from w2c.geometry import Intrinsics, Matrix, apply
from w2c_perception.patch import Points
from w2c_perception.window import DepthPicture

Heights = npt.NDArray[np.float32]

SPACING = 0.006
"""Between points that are used, at one metre [m]: several of them in a cell"""
FEWEST = 2
"""Points that make a cell seen: a single one may be a stray between near and far"""
CEILING = 2.2
"""What hangs higher is in nobody's way [m]"""
ARM_RADIUS = 0.10
"""Of the robot's arms with hands, sleeves and the error of the camera's pose [m]"""


@dataclass(frozen=True)
class Area:
    """The part of the floor that is looked at, in cells."""

    x: tuple[float, float] = (0.1, 1.7)
    """From and to, ahead of the robot [m]"""
    y: tuple[float, float] = (-1.0, 1.0)
    """From right to left [m]"""
    cell: float = 0.02

    @property
    def shape(self) -> tuple[int, int]:
        """Rows along x, columns along y."""
        return (
            round((self.x[1] - self.x[0]) / self.cell),
            round((self.y[1] - self.y[0]) / self.cell),
        )


def height_field(
    depth: DepthPicture,
    intrinsics: Intrinsics,
    world_from_camera: Matrix,
    arms: Points,
    area: Area | None = None,
) -> Heights:
    """Return the highest point seen in each cell (rows, columns) [m]; NaN where none was.

    Args:
        depth: (h, w) z-depth [m], 0 = unknown.
        intrinsics: Of the picture.
        world_from_camera: (4, 4).
        arms: (n, 2, 3) segments along the bones of the robot's arms in the world [m]; what is
            within `ARM_RADIUS` of them is the robot, and what is behind it is not seen.
        area: Of the grid; None: what the arms reach.
    """
    area = area or Area()
    points = _points(depth, intrinsics, world_from_camera)
    row = np.floor((points[:, 0] - area.x[0]) / area.cell).astype(np.intp)
    column = np.floor((points[:, 1] - area.y[0]) / area.cell).astype(np.intp)
    rows, columns = area.shape
    inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
    inside &= points[:, 2] < CEILING
    points, index = points[inside], (row * columns + column)[inside]
    kept = ~on_arms(points, arms)
    points, index = points[kept], index[kept]
    highest = np.full(rows * columns, -np.inf)
    np.maximum.at(highest, index, points[:, 2])
    seen = np.bincount(index, minlength=rows * columns) >= FEWEST
    heights = np.where(seen, highest, np.nan).astype(np.float32)
    return np.asarray(heights.reshape(rows, columns))


def _points(depth: DepthPicture, intrinsics: Intrinsics, world_from_camera: Matrix) -> Points:
    """Return points (n, 3) in the world, thinned to `SPACING`."""
    stride = max(1, int(SPACING * intrinsics.fx))
    thinned = depth[::stride, ::stride]
    rows, columns = np.nonzero(thinned > 0.0)
    z = thinned[rows, columns].astype(np.float64)
    along = intrinsics.rays(columns * stride + 0.5, rows * stride + 0.5)
    return apply(world_from_camera, z[:, None] * along)


def on_arms(points: Points, arms: Points) -> npt.NDArray[np.bool_]:
    """Return which points (n,) are within `ARM_RADIUS` of a segment."""
    found = np.zeros(len(points), dtype=bool)
    if not len(arms):
        return found
    candidates = _in_box(points, arms.reshape(-1, 3))
    points = points[candidates]
    for start, end in arms:
        near = _in_box(points, np.stack([start, end]))
        along = end - start
        squared = max(float(along @ along), 1e-12)
        offset = points[near] - start
        share = np.clip(offset @ along / squared, 0.0, 1.0)
        away = np.linalg.norm(offset - share[:, None] * along, axis=1)
        found[candidates[near[away < ARM_RADIUS]]] = True
    return found


def _in_box(points: Points, corners: Points) -> npt.NDArray[np.intp]:
    """Return the indices of points (n, 3) in the box around corners (m, 3), `ARM_RADIUS` wider."""
    low, high = corners.min(axis=0) - ARM_RADIUS, corners.max(axis=0) + ARM_RADIUS
    inside = np.ones(len(points), dtype=bool)
    for axis in range(3):
        inside &= (points[:, axis] > low[axis]) & (points[:, axis] < high[axis])
    return np.flatnonzero(inside)
