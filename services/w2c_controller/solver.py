"""Strictly convex quadratic programs: daqp first, piqp where it fails.

min 1/2 x'Hx + g'x   s.t.   Ax = b,   l <= Cx <= u,   lower <= x <= upper
"""

from dataclasses import dataclass, field
from typing import Any, Protocol

import daqp
import numpy as np
import numpy.typing as npt
import piqp

from w2c.errors import SolverError

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]

UNBOUNDED = 1e30
"""Bounds at or beyond this are none."""
_EQUALITY = 5


@dataclass
class Program:
    """One QP, reused in place. `rows` holds the equalities, then the two-sided inequalities."""

    hessian: Matrix
    """H (n, n), symmetric, positive definite"""
    gradient: Vector
    """g (n,)"""
    rows: Matrix
    """[A; C] (m, n)"""
    lower: Vector
    """(n + m,) bounds of x, then of the rows"""
    upper: Vector
    equalities: int
    """How many of the rows are equalities; their lower equals their upper"""

    @classmethod
    def empty(cls, size: int, equalities: int, inequalities: int) -> "Program":
        """Allocate a program without cost or bounds."""
        rows = equalities + inequalities
        return cls(
            hessian=np.zeros((size, size)),
            gradient=np.zeros(size),
            rows=np.zeros((rows, size)),
            lower=np.full(size + rows, -UNBOUNDED),
            upper=np.full(size + rows, UNBOUNDED),
            equalities=equalities,
        )

    @property
    def size(self) -> int:
        """Number of variables."""
        return int(self.gradient.shape[0])

    def violation(self, x: Vector) -> float:
        """Return how far x is outside the worst bound or row."""
        values = np.concatenate([x, self.rows @ x])
        return float(max(np.max(self.lower - values), np.max(values - self.upper), 0.0))


class Solver(Protocol):
    """Solves one program after another."""

    def solve(self, program: Program) -> Vector:
        """Return the optimum x (n,). Raises SolverError, which carries the program."""


class UnsolvedError(SolverError):
    """A QP without an optimum, with the QP."""

    def __init__(self, message: str, program: Program) -> None:
        super().__init__(message)
        self.program = program


class DaqpSolver:
    """Dual active set (Arnström, Bemporad and Axehill, IEEE TAC 2022): exact.

    Fast while few rows are active.
    """

    def __init__(self) -> None:
        self._senses: dict[tuple[int, int], npt.NDArray[np.int32]] = {}

    def solve(self, program: Program) -> Vector:
        """Return the optimum (n,). Raises SolverError."""
        x, _, flag, _ = daqp.solve(
            program.hessian,
            program.gradient,
            program.rows,
            program.upper,
            program.lower,
            self._sense(program),
            primal_tol=1e-8,
            iter_limit=500,
        )
        if flag != 1 or not np.isfinite(x).all():
            raise UnsolvedError(
                f"daqp ends with flag {flag} (1 = optimal, -1 = infeasible)", program
            )
        return np.asarray(x)

    def _sense(self, program: Program) -> npt.NDArray[np.int32]:
        """Return the flags of the constraints; daqp writes into them, so they are a fresh copy."""
        key = (program.size, program.rows.shape[0])
        if key not in self._senses:
            sense = np.zeros(sum(key), dtype=np.int32)
            sense[program.size : program.size + program.equalities] = _EQUALITY
            self._senses[key] = sense
        return self._senses[key].copy()


class PiqpSolver:
    """Proximal interior point (Schwan, Jiang, Kuhn and Jones, CDC 2023): robust to degeneracy."""

    def solve(self, program: Program) -> Vector:
        """Return the optimum (n,). Raises SolverError."""
        n, k = program.size, program.equalities
        solver = piqp.DenseSolver()
        solver.settings.eps_abs = 1e-8
        solver.settings.eps_rel = 1e-9
        arguments: list[Any] = [
            np.asfortranarray(program.hessian),
            program.gradient,
            np.asfortranarray(program.rows[:k]),
            program.upper[n : n + k],
            np.asfortranarray(program.rows[k:]),
            program.lower[n + k :],
            program.upper[n + k :],
            program.lower[:n],
            program.upper[:n],
        ]
        solver.setup(*arguments)
        status = solver.solve()
        if status != piqp.PIQP_SOLVED:
            raise UnsolvedError(f"piqp ends with {status}", program)
        return np.array(solver.result.x)


@dataclass
class FallbackSolver:
    """The first solver, and the second where the first fails; counts both."""

    first: Solver = field(default_factory=DaqpSolver)
    second: Solver = field(default_factory=PiqpSolver)
    fallbacks: int = 0
    failures: int = 0

    def solve(self, program: Program) -> Vector:
        """Return the optimum (n,). Raises SolverError when neither finds one."""
        try:
            return self.first.solve(program)
        except SolverError:
            self.fallbacks += 1
        try:
            return self.second.solve(program)
        except SolverError:
            self.failures += 1
            raise
