"""The set of bounds that are taken for active: its list, and when another one is exceeded."""

from typing import Final

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled
from w2c_controller.solvers.program import Flags, Matrix, Vector

Indices = npt.NDArray[np.intp]

TOLERANCE: Final = 3e-9
"""By how much a bound may be exceeded, in its own unit, and as a share of it."""
LARGEST_TOLERANCE: Final = 1e-7
"""Rows that nearly depend on each other (two feet push against each other) are told apart no better
than to 1e-8 of their bounds: without this two sets would be tried in turn."""


@compiled
def slack(bound: float) -> float:
    """Return by how much a bound may be exceeded."""
    return min(TOLERANCE * (1.0 + abs(bound)), LARGEST_TOLERANCE)


@compiled
def collect(active: Flags, working: Indices) -> int:
    """List the active bounds. Returns how many there are; -1 if too many."""
    count = 0
    for i in range(active.shape[0]):
        if active[i] != 0:
            if count == working.shape[0]:
                return -1
            working[count] = i
            count += 1
    return count


@compiled
def value_of(x: Vector, rows: Matrix, i: int) -> float:
    """Return what bound i is on: a variable, or a row."""
    n = x.shape[0]
    if i < n:
        return float(x[i])
    value = 0.0
    for j in range(n):
        value += rows[i - n, j] * x[j]
    return value
