"""Rotation vectors, compiled."""

import math

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]


@compiled
def rotation_vector(rotation: Matrix, out: Vector) -> None:
    """Fill the axis times the angle (3,) of a rotation (3, 3), for angles below pi [rad]."""
    x = 0.5 * (rotation[2, 1] - rotation[1, 2])
    y = 0.5 * (rotation[0, 2] - rotation[2, 0])
    z = 0.5 * (rotation[1, 0] - rotation[0, 1])
    sine = math.sqrt(x * x + y * y + z * z)
    cosine = 0.5 * (rotation[0, 0] + rotation[1, 1] + rotation[2, 2] - 1.0)
    scale = math.atan2(sine, cosine) / sine if sine > 1e-12 else 1.0
    out[0], out[1], out[2] = scale * x, scale * y, scale * z
