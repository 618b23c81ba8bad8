"""Compiled linear algebra of the active set solver: LDL' of the KKT matrix, limb by limb.

    [H A'] [x ]   [-g]
    [A 0 ] [nu] = [ b]

has LDL' factors without row exchanges where H is positive definite and the equalities of each limb
are independent on its own variables (Vanderbei, SIAM J. Optimization 1995). Eliminated from limb to
trunk it fills in nothing but limbs and border (Featherstone, "Efficient Factorization of the
Joint-Space Inertia Matrix for Branched Kinematic Trees", IJRR 2005).

The factor is packed: a row of a limb holds the limb's columns, then those of the trunk, then the
right-hand side; see `Structure`. All inner loops run along rows in memory.
"""

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]
Places = npt.NDArray[np.int32]

LEAST_PIVOT = 1e-13
"""A pivot smaller than this share of its own diagonal entry means a dependent row."""


@compiled
def load(
    hessian: Matrix,
    gradient: Vector,
    rows: Matrix,
    right: Vector,
    order: Indices,
    starts: Indices,
    to_factor: Places,
    of_hessian: Places,
    to_border: Places,
    of_rows: Places,
    factor: Matrix,
) -> None:
    """Copy the KKT system into the packed factor (N, width).

    `right` (n + m,) are bounds, of which those of the equalities are read; the indices are those
    of `Structure`.
    """
    size = gradient.shape[0]
    flat, flat_hessian = factor.reshape(factor.size), hessian.reshape(hessian.size)
    flat_rows = rows.reshape(rows.size)
    for i in range(flat.shape[0]):
        flat[i] = 0.0
    for i in range(to_factor.shape[0]):
        flat[to_factor[i]] = flat_hessian[of_hessian[i]]
    for i in range(to_border.shape[0]):
        flat[to_border[i]] = flat_rows[of_rows[i]]
    trunk = starts[starts.shape[0] - 2]
    total = order.shape[0]
    for block in range(starts.shape[0] - 1):
        first, end = starts[block], starts[block + 1]
        last = end - first + (total - trunk if end <= trunk else 0)
        for row in range(first, end):
            source = order[row]
            factor[row, last] = -gradient[source] if source < size else right[source]


@compiled
def subtract(target: Vector, share: float, source: Vector) -> None:
    """Subtract a share of a vector from another of the same length."""
    for j in range(target.shape[0]):
        target[j] -= share * source[j]


@compiled
def dot(a: Vector, b: Vector) -> float:
    """Return the product of two vectors of the same length."""
    product = 0.0
    for j in range(a.shape[0]):
        product += a[j] * b[j]
    return product


@compiled
def factorise(
    factor: Matrix, order: Indices, starts: Indices, size: int, inverse: Vector, right: Vector
) -> bool:
    """Replace the KKT matrix by U of U'DU.

    `inverse` (N,) becomes D^-1 and `right` (N,) D^-1 U^-T of the right-hand side. Pivots of
    variables must be positive, those of equalities negative.

    Returns:
        Whether they are.
    """
    trunk, total = starts[starts.shape[0] - 2], order.shape[0]
    for block in range(starts.shape[0] - 1):
        first, end = starts[block], starts[block + 1]
        inside = end - first
        border = total - trunk if end <= trunk else 0
        length = inside + border + 1
        for row in range(first, end):
            right[row] = abs(factor[row, row - first])
        for k in range(inside):
            row = first + k
            source = factor[row, :length]
            pivot = source[k] if order[row] < size else -source[k]
            if not pivot > LEAST_PIVOT * right[row]:
                return False
            share = 1.0 / source[k]
            inverse[row] = share
            for i in range(k + 1, inside):
                if source[i] != 0.0:
                    subtract(factor[first + i, i:length], source[i] * share, source[i:])
            for i in range(border):
                entry = source[inside + i]
                if entry != 0.0:
                    target = factor[trunk + i, i : border + 1]
                    subtract(target, entry * share, source[inside + i :])
            for j in range(k + 1, length):
                source[j] *= share
            right[row] = source[length - 1]
    return True


@compiled
def eliminate(factor: Matrix, starts: Indices, column: Vector) -> None:
    """Replace a column c (N,), in the order of elimination, by U^-T c."""
    blocks, total = starts.shape[0] - 1, column.shape[0]
    trunk = starts[blocks - 1]
    for block in range(blocks):
        first, end = starts[block], starts[block + 1]
        inside = end - first
        border = total - trunk if end <= trunk else 0
        for k in range(inside):
            share = column[first + k]
            if share != 0.0:
                source = factor[first + k]
                subtract(column[first + k + 1 : end], share, source[k + 1 : inside])
                subtract(column[trunk : trunk + border], share, source[inside : inside + border])


@compiled
def substitute(factor: Matrix, starts: Indices, column: Vector) -> None:
    """Replace a column y (N,), in the order of elimination, by U^-1 y."""
    blocks, total = starts.shape[0] - 1, column.shape[0]
    trunk = starts[blocks - 1]
    for back in range(blocks):
        block = blocks - 1 - back
        first, end = starts[block], starts[block + 1]
        inside = end - first
        border = total - trunk if end <= trunk else 0
        for i in range(inside):
            k = inside - 1 - i
            source = factor[first + k]
            column[first + k] -= dot(source[k + 1 : inside], column[first + k + 1 : end]) + dot(
                source[inside : inside + border], column[trunk : trunk + border]
            )


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
    reduce_positive(matrix, right, least, used, size, size)
    substitute_positive(matrix, right, used, size)


@compiled
def reduce_positive(
    matrix: Matrix, right: Vector, least: Vector, used: Vector, count: int, size: int
) -> None:
    """Eliminate the first rows of S mu = r; see `solve_positive`.

    Of the others, S and r become what is left when the first are solved for.
    """
    for k in range(count):
        pivot = matrix[k, k]
        used[k] = 1.0 if pivot > least[k] else 0.0
        if used[k] == 0.0:
            right[k] = 0.0
            continue
        inverse = 1.0 / pivot
        source = matrix[k, :size]
        for i in range(k + 1, size):
            share = source[i] * inverse
            if share != 0.0:
                subtract(matrix[i, i:size], share, source[i:])
                right[i] -= share * right[k]
        for j in range(k + 1, size):
            source[j] *= inverse
        right[k] *= inverse


@compiled
def substitute_positive(matrix: Matrix, right: Vector, used: Vector, count: int) -> None:
    """Find mu (count,) from a reduced right-hand side, in place; see `reduce_positive`."""
    for i in range(count):
        k = count - 1 - i
        if used[k] != 0.0:
            right[k] -= dot(matrix[k, k + 1 : count], right[k + 1 : count])
        else:
            right[k] = 0.0
