"""What stands in the way, in words: where, how high, how large."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from w2c_controller.motion.terrain import FREE, Terrain

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]

SAME_THING = 0.05
"""Neighbouring cells that are not lower than its top by more belong to the same thing [m]."""


@dataclass(frozen=True)
class Obstacle:
    """A thing in the height field."""

    x: float
    """Middle, in the world [m]"""
    y: float
    height: float
    """Of its top above the floor [m]"""
    size: tuple[float, float]
    """Along x and y [m]"""

    def text(self) -> str:
        """Return it in words."""
        return (
            f"something {self.height:.2f} m high at x {self.x:.2f}, y {self.y:.2f} m "
            f"({self.size[0]:.2f} x {self.size[1]:.2f} m)"
        )


def find_obstacle(terrain: Terrain, position: Vector, clearance: float) -> Obstacle | None:
    """Return the highest thing within reach of the arm's balls at a position; None: there is none.

    Args:
        terrain: Of the arm.
        position: (3,) of the hand [m].
        clearance: That the arm keeps [m].
    """
    arm, heights = terrain.arm, terrain.obstacles
    rows, columns = heights.shape
    x = terrain.origin[0] + (np.arange(rows) + 0.5) * terrain.cell
    y = terrain.origin[1] + (np.arange(columns) + 0.5) * terrain.cell
    radius = arm.radius + clearance + 1.5 * terrain.cell
    most, found = 0.0, (-1, -1)
    for centre in terrain.balls(position):
        near = np.hypot(x[:, None] - centre[0], y[None, :] - centre[1]) < radius
        excess = np.where(near & (heights > FREE), heights - centre[2] + radius, 0.0)
        row, column = np.unravel_index(int(np.argmax(excess)), excess.shape)
        if excess[row, column] > most:
            most, found = float(excess[row, column]), (int(row), int(column))
    if found[0] < 0:
        return None
    return _thing(terrain, *found)


def _thing(terrain: Terrain, row: int, column: int) -> Obstacle:
    """Return the thing that a cell belongs to: the cells around it that are as high."""
    heights = terrain.obstacles
    lowest = heights[row, column] - SAME_THING
    waiting, members = [(row, column)], {(row, column)}
    while waiting:
        i, j = waiting.pop()
        for a, b in ((i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)):
            inside = 0 <= a < heights.shape[0] and 0 <= b < heights.shape[1]
            if inside and (a, b) not in members and heights[a, b] >= lowest:
                members.add((a, b))
                waiting.append((a, b))
    cells = np.array(sorted(members))
    low, high = cells.min(axis=0), cells.max(axis=0) + 1
    middle = terrain.origin + 0.5 * terrain.cell * (low + high)
    return Obstacle(
        x=float(middle[0]),
        y=float(middle[1]),
        height=float(heights[cells[:, 0], cells[:, 1]].max()),
        size=(
            float(terrain.cell * (high[0] - low[0])),
            float(terrain.cell * (high[1] - low[1])),
        ),
    )
