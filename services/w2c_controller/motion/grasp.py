"""How a hand points at what it reaches for, and how far from it it stops.

Fingers first, from above, squarely to a surface that stands upright. The frame of an open hand is
between its fingertips, so the corners of the tips stand before the frame as seen from a surface
that the hand does not meet squarely: by them, the hand stops farther off.
"""

import math

import numpy as np
import numpy.typing as npt

from w2c.geometry import unit

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]

STEEPEST = math.radians(45.0)
FLATTEST = math.radians(25.0)
"""Of fingers that point down: flatter, and the palm meets the table before they meet the object."""
STEEPER = tuple(math.radians(degrees) for degrees in (0.0, 10.0, 20.0, 30.0, 35.0))
"""What the fingers may point down more, where something stands before the point"""
STEEPEST_OVER = math.radians(60.0)
"""Then; a wrist that is far away turns no farther."""
FACES_DOWN = -0.3
"""A surface with a smaller z of its normal is approached from below, at most level."""
UPRIGHT = 0.5
"""Level part of the normal of a surface that fingers turn to entirely"""
LARGEST_TURN = math.radians(30.0)
"""Of the fingers sideways from straight ahead, towards a surface that faces sideways"""

REACH_STANDOFF = 0.02
"""Of a hand that reaches, off the surface, along its normal [m]"""
FARTHEST_STANDOFF = 0.037
"""Where its fingertips would touch otherwise [m]"""
TIP_MARGIN = 0.01
"""Of the fingertips to the surface [m]"""
FINGERTIPS = np.array(
    [
        [0.048, 0.071, 0.0],
        [-0.048, 0.071, 0.0],
        [0.016, -0.071, 0.0],
        [-0.016, -0.071, 0.0],
    ]
)
"""(4, 3) outermost corners of the open hand's fingertips in its frame [m]"""


def approach_direction(point: Vector, normal: Vector, steeper: float = 0.0) -> Vector:
    """Return the direction (3,) in which the fingers of a reaching hand point, in the world.

    Midway between straight ahead and into the surface, within the pitch that a wrist and a table
    allow; turned sideways to a surface, the more upright it stands.

    Args:
        point: (3,) to be reached [m].
        normal: (3,) unit, out of the surface.
        steeper: That the fingers shall point down more [rad].
    """
    ahead = _turned(unit([point[0], point[1], 0.0]), normal)
    inwards = ahead - normal
    pitch = math.atan2(-float(inwards[2]), float(ahead @ inwards))
    if normal[2] > FACES_DOWN:
        pitch = min(max(pitch, FLATTEST), STEEPEST)
        pitch = max(min(pitch + steeper, STEEPEST_OVER), pitch)
    else:
        pitch = min(max(pitch, -STEEPEST), 0.0)
    down = np.array([0.0, 0.0, -1.0])
    return math.cos(pitch) * ahead + math.sin(pitch) * down


def _turned(ahead: Vector, normal: Vector) -> Vector:
    """Return a level direction (3,), turned towards a surface that faces it, as far as allowed."""
    x, y = -float(normal @ ahead), float(normal[0] * ahead[1] - normal[1] * ahead[0])
    if x <= 0.0:
        return ahead
    turn = min((x * x + y * y) / UPRIGHT**2, 1.0) * math.atan2(y, x)
    turn = min(max(turn, -LARGEST_TURN), LARGEST_TURN)
    c, s = math.cos(turn), math.sin(turn)
    return np.array([c * ahead[0] - s * ahead[1], s * ahead[0] + c * ahead[1], 0.0])


def pointing_rotation(fingers: Vector) -> Matrix:
    """Return world_from_hand (3, 3) of a hand whose fingers point this way, opened sideways.

    The hand frame of Talos: fingers along -z, opening along y. Opened sideways, the fingers pass
    left and right of what they reach for.
    """
    z = -fingers
    sideways = unit(np.cross([0.0, 0.0, 1.0], fingers))
    return np.column_stack([np.cross(sideways, z), sideways, z])


def standoff(fingers: Vector, normal: Vector) -> float:
    """Return how far off a surface the frame of an open hand stops, along the normal [m].

    Args:
        fingers: (3,) unit, in which they point.
        normal: (3,) unit, out of the surface, taken as a plane.
    """
    tips = FINGERTIPS @ pointing_rotation(fingers).T
    before = -float((tips @ normal).min())
    return min(max(before + TIP_MARGIN, REACH_STANDOFF), FARTHEST_STANDOFF)
