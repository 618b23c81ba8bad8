"""Compiled linear algebra of the active set solver: one sparse-skipping LDL' of the KKT matrix.

    [H A'] [x ]   [-g]
    [A 0 ] [nu] = [ b]

is quasi-definite for a positive definite H and independent rows A, so that it has LDL' factors for
every order of its rows (Vanderbei, SIAM J. Optimization 1995). Variables are eliminated from the
last to the first: those of a kinematic tree stand in depth-first order with the base first, and
from leaf to root the factors fill in nothing (Featherstone, "Efficient Factorization of the
Joint-Space Inertia Matrix for Branched Kinematic Trees", IJRR 2005). Zeros are skipped, so that
the time follows the tree without the code knowing it. All inner loops run along rows in memory.
"""

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]

LEAST_PIVOT = 1e-13
"""A pivot smaller than this share of its own diagonal entry means a dependent row."""


@compiled
def load(
    factor: Matrix,
    hessian: Matrix,
    gradient: Vector,
    rows: Matrix,
    right: Vector,
    equalities: int,
) -> None:
    """Copy the KKT system into the upper triangle of `factor` (N, N + 1), its right side last.

    Variable j stands in row n - 1 - j, equality i in row n + i; N = n + equalities.

    Args:
        factor: Written.
        hessian: (n, n) upper triangle.
        gradient: (n,)
        rows: (m, n) equalities first.
        right: (n + m,) bounds of which those of the equalities are read.
        equalities: Number of equalities.
    """
    n = gradient.shape[0]
    total = n + equalities
    for i in range(n):
        row = n - 1 - i
        for j in range(i + 1):
            factor[row, n - 1 - j] = hessian[j, i]
        for j in range(equalities):
            factor[row, n + j] = rows[j, i]
        factor[row, total] = -gradient[i]
    for i in range(equalities):
        for j in range(n + i, total):
            factor[n + i, j] = 0.0
        factor[n + i, total] = right[n + i]


@compiled
def factorise(factor: Matrix, inverse: Vector, size: int, total: int) -> bool:
    """Replace the upper triangle by U of U'DU, and the last column by D^-1 U^-T of it.

    Args:
        factor: (N, N + 1) in and out.
        inverse: (N,) D^-1, out.
        size: n, how many pivots must be positive; the others must be negative.
        total: N

    Returns:
        Whether all pivots have their sign.
    """
    for k in range(total):
        inverse[k] = LEAST_PIVOT * abs(factor[k, k])
    for k in range(total):
        pivot = factor[k, k]
        least = inverse[k]
        if k < size:
            if not pivot > least:
                return False
        elif not pivot < -least:
            return False
        share_of_pivot = 1.0 / pivot
        inverse[k] = share_of_pivot
        for i in range(k + 1, total):
            entry = factor[k, i]
            if entry != 0.0:
                share = entry * share_of_pivot
                for j in range(i, total + 1):
                    factor[i, j] -= share * factor[k, j]
        for j in range(k + 1, total + 1):
            factor[k, j] *= share_of_pivot
    return True


@compiled
def eliminate(factor: Matrix, column: Vector, total: int) -> None:
    """Replace a column c (N,) by U^-T c."""
    for k in range(total):
        share = column[k]
        if share != 0.0:
            for j in range(k + 1, total):
                column[j] -= share * factor[k, j]


@compiled
def substitute(factor: Matrix, column: Vector, total: int) -> None:
    """Replace a column y (N,) by U^-1 y."""
    for i in range(total):
        k = total - 1 - i
        rest = column[k]
        for j in range(k + 1, total):
            rest -= factor[k, j] * column[j]
        column[k] = rest


@compiled
def solve_positive(matrix: Matrix, right: Vector, least: Vector, used: Vector, size: int) -> None:
    """Solve S mu = r in place for a positive semidefinite S; rows that depend on others get 0.

    Args:
        matrix: (size, size) upper triangle of S; overwritten.
        right: (size,) r in, mu out.
        least: (size,) pivots at or below are zero.
        used: (size,) out: 1 where the row counts, 0 where it depends on those before.
        size: Number of rows.
    """
    for k in range(size):
        pivot = matrix[k, k]
        used[k] = 1.0 if pivot > least[k] else 0.0
        if used[k] == 0.0:
            right[k] = 0.0
            continue
        inverse = 1.0 / pivot
        for i in range(k + 1, size):
            share = matrix[k, i] * inverse
            if share != 0.0:
                for j in range(i, size):
                    matrix[i, j] -= share * matrix[k, j]
                right[i] -= share * right[k]
        for j in range(k + 1, size):
            matrix[k, j] *= inverse
        right[k] *= inverse
    for i in range(size):
        k = size - 1 - i
        if used[k] != 0.0:
            rest = right[k]
            for j in range(k + 1, size):
                rest -= matrix[k, j] * right[j]
            right[k] = rest
