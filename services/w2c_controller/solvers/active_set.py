"""A warm-started primal-dual active set method, compiled.

The bounds that held at the last optimum of the same program are taken as equalities. If the point
that this gives violates no other bound and no multiplier has a wrong sign, it is the optimum: H is
positive definite, and the conditions of Karush, Kuhn and Tucker suffice. If not, all wrong rows are
swapped at once and the next set is tried (Hintermüller, Ito and Kunisch, SIAM J. Optimization
2003). From one tick to the next the set is nearly always the same. Swaps need not end; after
`MOST_SETS` the program is left to another solver.

The equalities are part of one factorisation a program; the active rows C_W come on top of it
through their Schur complement S = C_W K^-1 C_W', so another set costs only its new rows.
"""

from typing import Final

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled
from w2c_controller.solvers.kkt import (
    dot,
    eliminate,
    factorise,
    load,
    solve_positive,
    substitute,
    subtract,
)
from w2c_controller.solvers.program import Flags, Matrix, Program, UnsolvedError, Vector
from w2c_controller.solvers.structure import Places, Structure

Indices = npt.NDArray[np.intp]

MOST_SETS: Final = 8
TOLERANCE: Final = 3e-9
"""By how much a bound may be exceeded, in its own unit, and as a share of it."""
LARGEST_TOLERANCE: Final = 1e-7
"""Rows that nearly depend on each other (two feet push against each other) are told apart no better
than to 1e-8 of their bounds: without this the two sets would be tried in turn for ever."""
DEPENDENT: Final = 1e-11
"""A row whose Schur complement is smaller than this share of its own entry depends on others."""

_NOT_CONVEX: Final = -1
_CYCLES: Final = -2
_CROWDED: Final = -3
_REASONS: Final = {
    _NOT_CONVEX: "the cost is not strictly convex, or the equalities depend on each other",
    _CYCLES: f"no optimum among {MOST_SETS} active sets",
    _CROWDED: "more bounds hold than there are free variables",
}


class _Workspace:
    """Arrays for programs of one structure and number of rows."""

    def __init__(self, structure: Structure, rows: int) -> None:
        size, total = structure.size, structure.total
        most = 2 * size - total + 1
        self.structure = (
            structure.order,
            structure.starts,
            structure.place,
            *structure.sources,
        )
        self.factor = np.zeros((total, structure.width))
        self.inverse = np.zeros(total)
        self.right = np.zeros(total)
        self.columns = np.zeros((size + rows, total))
        """U^-T of the normal of a bound, filled when it is first active"""
        self.ready = np.zeros(size + rows, dtype=np.int8)
        self.schur = np.zeros((most, most))
        self.vectors = np.zeros((4, most))
        self.point = np.zeros(total)
        self.multipliers = np.zeros(size + rows)
        self.working = np.zeros(most, dtype=np.intp)
        self.x = np.zeros(size)


class ActiveSetSolver:
    """Starts each program from the active set of its last optimum. Not for two threads."""

    def __init__(self) -> None:
        self._workspaces: dict[tuple[Structure, int], _Workspace] = {}
        self.iterations = 0
        """Active sets tried, over all programs."""
        self._last: _Workspace | None = None

    @property
    def multipliers(self) -> Vector:
        """Return those of the last program solved (n + m,), as `Program.residual` takes them."""
        return np.zeros(0) if self._last is None else self._last.multipliers

    def prepare(self, program: Program) -> None:
        """Allocate the arrays for programs of this shape."""
        self._workspace(program)

    def solve(self, program: Program) -> Vector:
        """Return the optimum (n,), valid until the next call. Raises UnsolvedError."""
        space = self._last = self._workspace(program)
        tried = solve_active_set(
            program.hessian,
            program.gradient,
            program.rows,
            program.lower,
            program.upper,
            program.equalities,
            program.active,
            *space.structure,
            space.factor,
            space.inverse,
            space.right,
            space.columns,
            space.ready,
            space.schur,
            space.vectors,
            space.point,
            space.multipliers,
            space.working,
            space.x,
        )
        if tried < 0:
            program.active[:] = 0
            self.iterations += MOST_SETS if tried == _CYCLES else 1
            raise UnsolvedError(f"active set: {_REASONS[tried]}", program)
        self.iterations += tried
        return space.x

    def _workspace(self, program: Program) -> _Workspace:
        key = (program.structure, program.rows.shape[0])
        space = self._workspaces.get(key)
        if space is None:
            space = self._workspaces[key] = _Workspace(*key)
        return space


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
        return _NOT_CONVEX
    for i in range(n + m):
        ready[i] = 0
    sizes, right, least, used = vectors[0], vectors[1], vectors[2], vectors[3]
    for tried in range(1, MOST_SETS + 1):
        count = _collect(active, working)
        if count < 0:
            return _CROWDED
        _eliminate_new(factor, starts, place, rows, working, count, columns, ready)
        _complement(columns, working, order, inverse, count, n, schur, sizes, least)
        for a in range(count):
            i = working[a]
            right[a] = dot(columns[i], reached) - (upper[i] if active[i] > 0 else lower[i])
        solve_positive(schur, right, least, used, count)
        for i in range(n + m):
            multipliers[i] = 0.0
        for a in range(count):
            multipliers[working[a]] = right[a]
        if not _meet(
            factor, starts, place, inverse, reached, columns, working, right, count, point, x
        ):
            return _NOT_CONVEX
        wrong = _release(active, working, lower, upper, right, sizes, used, count)
        wrong += _arrest(x, rows, lower, upper, equalities, active)
        if wrong == 0:
            for i in range(equalities):
                multipliers[n + i] = point[place[n + i]]
            return tried
    return _CYCLES


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
def _eliminate_new(
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
def _meet(
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


@compiled
def _complement(
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
