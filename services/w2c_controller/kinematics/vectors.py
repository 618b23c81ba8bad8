"""Small things done to vectors at each tick, compiled: numpy would spend its time on the way in."""

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled

Vector = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]


@compiled
def largest_difference(a: Vector, b: Vector) -> float:
    """Return the largest |a - b| of two vectors (n,); NaN in either counts as none."""
    largest = 0.0
    for i in range(a.shape[0]):
        difference = abs(a[i] - b[i])
        if difference > largest:  # noqa: PLR1730, a comparison that NaN does not pass
            largest = difference
    return largest


@compiled
def look_ahead(
    q: Vector, velocity: Vector, ahead_time: float, offset: Vector, indices: Indices, out: Vector
) -> None:
    """Fill the joint angles (nj,) of a posture some time ahead, plus an offset (nj,) [rad].

    `indices` (nj,) say where each joint stands in `out` (n,).
    """
    for i in range(indices.shape[0]):
        out[indices[i]] = q[7 + i] + ahead_time * velocity[6 + i] + offset[i]
