"""Which bounds hold at the optimum: sets are tried in turn, each from the errors of the last.

The bounds of a set are taken as equalities. If the point that this gives violates no other bound
and no multiplier has a wrong sign, it is the optimum: H is positive definite, and the conditions of
Karush, Kuhn and Tucker suffice. If not, all wrong rows are swapped at once and the next set is
tried (Hintermüller, Ito and Kunisch, SIAM J. Optimization 2003). From one tick to the next the set
is nearly always the same. Swaps need not end; after `MOST_SETS` bounds join and leave one by one,
from the set that came first (`dual_steps`).
"""

from typing import Final

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled
from w2c_controller.solvers.dual_steps import MOST_STEPS, step_to_optimum
from w2c_controller.solvers.kkt import dot, factorise, load, solve_positive
from w2c_controller.solvers.program import Flags, Matrix, Vector
from w2c_controller.solvers.schur import complement, eliminate_new, meet
from w2c_controller.solvers.structure import Places
from w2c_controller.solvers.working_set import collect, slack, value_of

Indices = npt.NDArray[np.intp]

MOST_SETS: Final = 3
MOST_TRIED: Final = MOST_SETS + MOST_STEPS

NOT_CONVEX: Final = -1
UNDECIDED: Final = -2
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
    first: Flags,
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

    `first` (n + m,) is overwritten, as all from `factor` on.

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
        first[i] = active[i]
    sizes, right, least, used = vectors[0], vectors[1], vectors[2], vectors[3]
    for tried in range(1, MOST_SETS + 1):
        count = collect(active, working)
        if count < 0 and tried == 1:
            return CROWDED
        if count < 0:
            break
        eliminate_new(factor, starts, place, rows, working, count, columns, ready)
        complement(columns, working, order, inverse, count, n, schur, sizes, least)
        for a in range(count):
            i = working[a]
            right[a] = dot(columns[i], reached) - (upper[i] if active[i] > 0 else lower[i])
        solve_positive(schur, right, least, used, count)
        if not meet(
            factor, starts, place, inverse, reached, columns, working, right, count, point, x
        ):
            return NOT_CONVEX
        wrong = _release(active, working, lower, upper, right, sizes, used, count)
        wrong += _arrest(x, rows, lower, upper, equalities, active)
        if wrong == 0:
            _note(multipliers, working, right, count, n, equalities, place, point)
            return tried
    for i in range(n + m):
        active[i] = first[i]
    steps = step_to_optimum(
        rows,
        lower,
        upper,
        equalities,
        active,
        order,
        starts,
        place,
        factor,
        inverse,
        reached,
        columns,
        ready,
        schur,
        vectors,
        point,
        working,
        x,
    )
    if steps < 0:
        return UNDECIDED
    _note(multipliers, working, right, collect(active, working), n, equalities, place, point)
    return MOST_SETS + steps


@compiled
def _note(
    multipliers: Vector,
    working: Indices,
    force: Vector,
    count: int,
    size: int,
    equalities: int,
    place: Indices,
    point: Vector,
) -> None:
    """Fill the multipliers of bounds and equalities (n + m,); of what does not hold they are 0."""
    for i in range(multipliers.shape[0]):
        multipliers[i] = 0.0
    for a in range(count):
        multipliers[working[a]] = force[a]
    for i in range(equalities):
        multipliers[size + i] = point[place[size + i]]


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
        elif force[a] * sizes[a] * active[i] < -slack(upper[i] if active[i] > 0 else lower[i]):
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
        value = value_of(x, rows, i)
        if value - upper[i] > slack(upper[i]):
            active[i] = 1
            wrong += 1
        elif lower[i] - value > slack(lower[i]):
            active[i] = -1
            wrong += 1
    return wrong
