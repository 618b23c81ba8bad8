"""The solver of the loop: each program starts from the bounds that held at its last optimum."""

from typing import Final

import numpy as np

from w2c_controller.solvers.primal_dual import (
    CROWDED,
    MOST_TRIED,
    NOT_CONVEX,
    UNDECIDED,
    solve_active_set,
)
from w2c_controller.solvers.program import Program, UnsolvedError, Vector
from w2c_controller.solvers.structure import Structure

_REASONS: Final = {
    NOT_CONVEX: "the cost is not strictly convex, or the equalities depend on each other",
    UNDECIDED: f"no optimum among {MOST_TRIED} active sets",
    CROWDED: "more bounds hold than there are free variables",
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
        self.first = np.zeros(size + rows, dtype=np.int8)
        self.schur = np.zeros((most, most))
        self.vectors = np.zeros((5, most))
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
            space.first,
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
            self.iterations += MOST_TRIED if tried == UNDECIDED else 1
            raise UnsolvedError(f"active set: {_REASONS[tried]}", program)
        self.iterations += tried
        return space.x

    def _workspace(self, program: Program) -> _Workspace:
        key = (program.structure, program.rows.shape[0])
        space = self._workspaces.get(key)
        if space is None:
            space = self._workspaces[key] = _Workspace(*key)
        return space
