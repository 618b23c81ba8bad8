"""Whether the surface behind a pixel carries a hand: what the shape says, as messages."""

import numpy as np

from w2c.geometry import Vector
from w2c.messages import FitnessVerdict
from w2c_perception.allowed import WALL
from w2c_perception.fitness import DOWN, Demands, Shape, judge
from w2c_perception.lift import Surface


def verdicts(surface: Surface, error_bound: float, footprint: float) -> list[FitnessVerdict]:
    """Return a verdict for each check of a surface.

    Args:
        surface: What was seen.
        error_bound: Of its point, with that of the camera's pose [m].
        footprint: Radius of what will touch it [m].
    """
    shape = Shape(
        normal=surface.normal,
        error_bound=error_bound,
        flatness=surface.flatness,
        extent=surface.extent,
        edge_distance=surface.edge_distance,
    )
    return [
        FitnessVerdict(
            check=verdict.check,
            fit=bool(verdict.fit),
            reason=verdict.reason,
            value=float(verdict.value),
            limit=float(verdict.limit),
        )
        for verdict in judge(shape, Demands(radius=footprint), load_on(surface.normal))
    ]


def load_on(normal: Vector) -> Vector:
    """Return how a hand pushes on a surface (3,): with weight, or into what is a wall."""
    wall = abs(float(normal[2])) <= float(np.cos(WALL))
    return np.asarray(-normal) if wall else DOWN
