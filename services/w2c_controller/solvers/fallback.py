"""The solver of the loop: each program goes to the next solver where one fails."""

from dataclasses import dataclass, field

import numpy as np

from w2c.errors import SolverError
from w2c_controller.solvers.active_set import ActiveSetSolver
from w2c_controller.solvers.daqp_solver import DaqpSolver
from w2c_controller.solvers.piqp_solver import PiqpSolver
from w2c_controller.solvers.program import Program, Solver, Vector


@dataclass
class FallbackSolver:
    """Warm-started active set, then daqp, then piqp."""

    solvers: tuple[Solver, ...] = field(
        default_factory=lambda: (ActiveSetSolver(), DaqpSolver(), PiqpSolver())
    )
    solves: int = 0
    """Programs given to it."""
    fallbacks: int = 0
    """Programs that the first solver left to the others."""
    failures: int = 0
    """Programs that none solved."""
    last: Program | None = None
    """The newest program."""

    @property
    def iterations(self) -> int:
        """Active sets that the first solver tried, over all programs."""
        return int(getattr(self.solvers[0], "iterations", 0))

    @property
    def active_rows(self) -> int:
        """Bounds that hold with equality in the newest solution."""
        return 0 if self.last is None else int(np.count_nonzero(self.last.active))

    def prepare(self, program: Program) -> None:
        """Allocate what the first solver needs for programs of this shape."""
        first = self.solvers[0]
        if isinstance(first, ActiveSetSolver):
            first.prepare(program)

    def solve(self, program: Program) -> Vector:
        """Return the optimum (n,), valid until the next call. Raises UnsolvedError if none does."""
        self.solves += 1
        self.last = program
        *before, last = self.solvers
        for index, solver in enumerate(before):
            try:
                return solver.solve(program)
            except SolverError:
                self.fallbacks += index == 0
        try:
            return last.solve(program)
        except SolverError:
            self.failures += 1
            raise
