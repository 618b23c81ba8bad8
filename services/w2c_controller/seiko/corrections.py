"""How far a state is from where it shall be, and how much of that one tick takes back."""

from typing import Final

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled
from w2c_controller.kinematics.rotations import rotation_between

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]

POSTURE: Final = 0
POSITION: Final = 1
ROTATION: Final = 2
BIAS_FORCE: Final = 3
BIAS_TORQUE: Final = 4
BIAS_POSITION: Final = 5
BIAS_ROTATION: Final = 6
CLAMPS: Final = 7
"""Where each clamp stands in the vector of clamps, and how many there are."""


@compiled
def clamped_share(x: float, y: float, z: float, limit: float) -> float:
    """Return the factor, at most 1, that brings the length of (x, y, z) to the limit."""
    length = np.sqrt(x * x + y * y + z * z)
    return limit / length if length > limit else 1.0


@compiled
def fill_drifts(
    positions: Matrix,
    rotations: Matrix,
    target_positions: Matrix,
    target_rotations: Matrix,
    drifts: Matrix,
) -> None:
    """Fill what is left to the target of each end effector (4, 6): p* - p, log(R* R^T)."""
    for k in range(4):
        for i in range(3):
            drifts[k, i] = target_positions[k, i] - positions[k, i]
        rotation_between(target_rotations[k], rotations[k], drifts[k, 3:])
