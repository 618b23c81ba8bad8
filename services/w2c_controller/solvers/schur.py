"""The optimum of one set of bounds: equalities on top of a factorisation that stays.

The equalities of a program are part of one factorisation K = U'DU; the active rows C_W come on top
of it through their Schur complement S = C_W K^-1 C_W', so another set costs only its new rows.
"""

from typing import Final

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled
from w2c_controller.solvers.kkt import eliminate, substitute, subtract
from w2c_controller.solvers.program import Flags, Matrix, Vector

Indices = npt.NDArray[np.intp]

DEPENDENT: Final = 1e-11
"""A row whose Schur complement is smaller than this share of its own entry depends on others."""


@compiled
def eliminate_new(
    factor: Matrix,
    starts: Indices,
    place: Indices,
    rows: Matrix,
    working: Indices,
    count: int,
    columns: Matrix,
    ready: Flags,
) -> None:
    """Fill U^-T c (N,) for each normal c in the set that was in no earlier one."""
    n = rows.shape[1]
    for a in range(count):
        i = working[a]
        if ready[i] != 0:
            continue
        ready[i] = 1
        column = columns[i]
        for j in range(column.shape[0]):
            column[j] = 0.0
        if i < n:
            column[place[i]] = 1.0
        else:
            for j in range(n):
                column[place[j]] = rows[i - n, j]
        eliminate(factor, starts, column)


@compiled
def complement(
    columns: Matrix,
    working: Indices,
    order: Indices,
    inverse: Vector,
    count: int,
    size: int,
    schur: Matrix,
    sizes: Vector,
    least: Vector,
) -> None:
    """Fill the upper triangle of S = C_W K^-1 C_W', its diagonal, and its least pivots."""
    for a in range(count):
        column = columns[working[a]]
        for b in range(a + 1):
            other = columns[working[b]]
            entry = 0.0
            for j in range(inverse.shape[0]):
                entry += column[j] * other[j] * inverse[j]
            schur[b, a] = entry
        sizes[a] = schur[a, a]
        alone = 0.0
        for j in range(inverse.shape[0]):
            if order[j] < size:
                alone += column[j] * column[j] * inverse[j]
        least[a] = DEPENDENT * alone


@compiled
def meet(
    factor: Matrix,
    starts: Indices,
    place: Indices,
    inverse: Vector,
    reached: Vector,
    columns: Matrix,
    working: Indices,
    force: Vector,
    count: int,
    point: Vector,
    x: Vector,
) -> bool:
    """Fill the point (N,) = x and equality multipliers under the forces of the set.

    Returns:
        Whether it is finite.
    """
    for j in range(point.shape[0]):
        point[j] = 0.0
    for a in range(count):
        subtract(point, force[a], columns[working[a]])
    for j in range(point.shape[0]):
        point[j] = reached[j] + point[j] * inverse[j]
    substitute(factor, starts, point)
    finite = 0.0
    for j in range(x.shape[0]):
        x[j] = point[place[j]]
        finite += x[j]
    return bool(np.isfinite(finite))
