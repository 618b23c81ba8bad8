"""Which bounds hold at the optimum: sets are tried in turn, each from the errors of the last.

The bounds of a set are taken as equalities. If the point that this gives violates no other bound
and no multiplier has a wrong sign, it is the optimum: H is positive definite, and the conditions of
Karush, Kuhn and Tucker suffice. If not, all wrong rows are swapped at once and the next set is
tried (Hintermüller, Ito and Kunisch, SIAM J. Optimization 2003). From one tick to the next the set
is nearly always the same. Swaps need not end; after `MOST_SETS` the program is left to another
solver.
"""

from typing import Final

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled
from w2c_controller.solvers.kkt import dot, factorise, load, solve_positive
from w2c_controller.solvers.program import Flags, Matrix, Vector
from w2c_controller.solvers.schur import complement, eliminate_new, meet
from w2c_controller.solvers.structure import Places

Indices = npt.NDArray[np.intp]

MOST_SETS: Final = 8
TOLERANCE: Final = 3e-9
"""By how much a bound may be exceeded, in its own unit, and as a share of it."""
LARGEST_TOLERANCE: Final = 1e-7
"""Rows that nearly depend on each other (two feet push against each other) are told apart no better
than to 1e-8 of their bounds: without this the two sets would be tried in turn for ever."""

NOT_CONVEX: Final = -1
CYCLES: Final = -2
CROWDED: Final = -3
"""What `solve_active_set` returns without an optimum"""


@compiled
def solve_active_set(
    hessian: Matrix,
    gradient: Vector,
    rows: Matrix,
    lower: Vector,
    upper: Vector,
    equalities: int,
    active: Flags,
    order: Indices,
    starts: Indices,
    place: Indices,
    to_factor: Places,
    of_hessian: Places,
    to_border: Places,
    of_rows: Places,
    factor: Matrix,
    inverse: Vector,
    reached: Vector,
    columns: Matrix,
    ready: Flags,
    schur: Matrix,
    vectors: Matrix,
    point: Vector,
    multipliers: Vector,
    working: Indices,
    x: Vector,
) -> int:
    """Find the optimum; see the module. `active` is the first set, and the last one after.

    Returns:
        How many sets were tried, or a negative reason.
    """
    n, m = gradient.shape[0], rows.shape[0]
    load(
        hessian,
        gradient,
        rows,
        upper,
        order,
        starts,
        to_factor,
        of_hessian,
        to_border,
        of_rows,
        factor,
    )
    if not factorise(factor, order, starts, n, inverse, reached):
        return NOT_CONVEX
    for i in range(n + m):
        ready[i] = 0
    sizes, right, least, used = vectors[0], vectors[1], vectors[2], vectors[3]
    for tried in range(1, MOST_SETS + 1):
        count = _collect(active, working)
        if count < 0:
            return CROWDED
        eliminate_new(factor, starts, place, rows, working, count, columns, ready)
        complement(columns, working, order, inverse, count, n, schur, sizes, least)
        for a in range(count):
            i = working[a]
            right[a] = dot(columns[i], reached) - (upper[i] if active[i] > 0 else lower[i])
        solve_positive(schur, right, least, used, count)
        for i in range(n + m):
            multipliers[i] = 0.0
        for a in range(count):
            multipliers[working[a]] = right[a]
        if not meet(
            factor, starts, place, inverse, reached, columns, working, right, count, point, x
        ):
            return NOT_CONVEX
        wrong = _release(active, working, lower, upper, right, sizes, used, count)
        wrong += _arrest(x, rows, lower, upper, equalities, active)
        if wrong == 0:
            for i in range(equalities):
                multipliers[n + i] = point[place[n + i]]
            return tried
    return CYCLES


@compiled
def _collect(active: Flags, working: Indices) -> int:
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
def _release(
    active: Flags,
    working: Indices,
    lower: Vector,
    upper: Vector,
    force: Vector,
    sizes: Vector,
    used: Vector,
    count: int,
) -> int:
    """Take bounds that pull, and those that depend on others, from the set.

    Returns:
        How many pulled.
    """
    wrong = 0
    for a in range(count):
        i = working[a]
        # Released alone, the bound would be left by at most |mu| S: rounding if that is tiny.
        if used[a] == 0.0:
            active[i] = 0
        elif force[a] * sizes[a] * active[i] < -_slack(upper[i] if active[i] > 0 else lower[i]):
            active[i] = 0
            wrong += 1
    return wrong


@compiled
def _arrest(
    x: Vector, rows: Matrix, lower: Vector, upper: Vector, equalities: int, active: Flags
) -> int:
    """Put bounds that x exceeds into the set. Returns how many they are."""
    n = x.shape[0]
    wrong = 0
    for i in range(n + rows.shape[0]):
        if active[i] != 0 or n <= i < n + equalities:
            continue
        if i < n:
            value = x[i]
        else:
            value = 0.0
            for j in range(n):
                value += rows[i - n, j] * x[j]
        if value - upper[i] > _slack(upper[i]):
            active[i] = 1
            wrong += 1
        elif lower[i] - value > _slack(lower[i]):
            active[i] = -1
            wrong += 1
    return wrong


@compiled
def _slack(bound: float) -> float:
    """Return by how much a bound may be exceeded."""
    return min(TOLERANCE * (1.0 + abs(bound)), LARGEST_TOLERANCE)
