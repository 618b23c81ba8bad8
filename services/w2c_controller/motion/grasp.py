"""How an open hand points at what it reaches for: fingers first, from above."""

import math

import numpy as np
import numpy.typing as npt

from w2c.geometry import unit

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]

STEEPEST = math.radians(45.0)
FLATTEST = math.radians(25.0)
"""Of fingers that point down: flatter, and the palm meets the table before they meet the object."""
FACES_DOWN = -0.3
"""A surface with a smaller z of its normal is approached from below, at most level."""


def approach_direction(point: Vector, normal: Vector) -> Vector:
    """Return the direction (3,) in which the fingers of a reaching hand point, in the world.

    Midway between straight ahead and into the surface, within the pitch that a wrist and a table
    allow.

    Args:
        point: (3,) to be reached [m].
        normal: (3,) unit, out of the surface.
    """
    ahead = unit([point[0], point[1], 0.0])
    inwards = ahead - normal
    pitch = math.atan2(-float(inwards[2]), float(ahead @ inwards))
    if normal[2] > FACES_DOWN:
        pitch = min(max(pitch, FLATTEST), STEEPEST)
    else:
        pitch = min(max(pitch, -STEEPEST), 0.0)
    down = np.array([0.0, 0.0, -1.0])
    return math.cos(pitch) * ahead + math.sin(pitch) * down


def pointing_rotation(fingers: Vector) -> Matrix:
    """Return world_from_hand (3, 3) of a hand whose fingers point this way, opened sideways.

    The hand frame of Talos: fingers along -z, opening along y. Opened sideways, the fingers pass
    left and right of what they reach for.
    """
    z = -fingers
    sideways = unit(np.cross([0.0, 0.0, 1.0], fingers))
    return np.column_stack([np.cross(sideways, z), sideways, z])
