"""A strictly convex quadratic program, and how good an answer to it is.

min 1/2 x'Hx + g'x   s.t.   Ax = b,   l <= Cx <= u,   lower <= x <= upper
"""

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
import numpy.typing as npt

from w2c.errors import SolverError
from w2c_controller.solvers.structure import Structure

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]
Flags = npt.NDArray[np.int8]

UNBOUNDED = 1e30
"""Bounds at or beyond this are none."""


@dataclass(eq=False)
class Program:
    """One QP, reused in place. `rows` holds the equalities, then the two-sided inequalities."""

    hessian: Matrix
    """H (n, n), symmetric, positive definite; solvers read its upper triangle only"""
    gradient: Vector
    """g (n,)"""
    rows: Matrix
    """[A; C] (m, n)"""
    lower: Vector
    """(n + m,) bounds of x, then of the rows"""
    upper: Vector
    equalities: int
    """How many of the rows are equalities; their lower equals their upper"""
    active: Flags = field(default_factory=lambda: np.zeros(0, dtype=np.int8))
    """(n + m,) which bound the last optimum lay on: -1 lower, 1 upper, 0 none. A solver that can
    start from it does, so a program keeps it from one tick to the next."""

    structure: Structure = field(default_factory=lambda: Structure.dense(0, 0))
    """What H and A couple; entries of H beyond it are not read. By default all may be coupled."""

    def __post_init__(self) -> None:
        if self.structure.total == 0:
            self.structure = Structure.dense(self.size, self.equalities)
        if self.active.size != self.lower.size:
            self.active = np.zeros(self.lower.size, dtype=np.int8)

    @classmethod
    def empty(
        cls, size: int, equalities: int, inequalities: int, structure: Structure | None = None
    ) -> "Program":
        """Allocate a program without cost or bounds."""
        rows = equalities + inequalities
        return cls(
            hessian=np.zeros((size, size)),
            gradient=np.zeros(size),
            rows=np.zeros((rows, size)),
            lower=np.full(size + rows, -UNBOUNDED),
            upper=np.full(size + rows, UNBOUNDED),
            equalities=equalities,
            structure=Structure.dense(size, equalities) if structure is None else structure,
        )

    @property
    def size(self) -> int:
        """Number of variables."""
        return int(self.gradient.shape[0])

    def full_hessian(self) -> Matrix:
        """Return H (n, n) with its lower triangle mirrored from the upper one."""
        upper = np.triu(self.hessian)
        return np.asarray(upper + np.triu(upper, 1).T)

    def violation(self, x: Vector) -> float:
        """Return how far x is outside the worst bound or row."""
        values = np.concatenate([x, self.rows @ x])
        return float(max(np.max(self.lower - values), np.max(values - self.upper), 0.0))

    def residual(self, x: Vector, multipliers: Vector) -> float:
        """Return how far x and multipliers are from the Karush-Kuhn-Tucker conditions.

        The largest of the violation of x, the slope |Hx + g + [I; A; C]' mu| that is left, and the
        size of multipliers of a wrong sign or of bounds that x does not touch.

        Args:
            x: (n,)
            multipliers: (n + m,) of the bounds of x, then of the rows: positive at an upper
                bound, negative at a lower one.
        """
        normals = np.vstack([np.eye(self.size), self.rows])
        values = normals @ x
        slope = self.full_hessian() @ x + self.gradient + normals.T @ multipliers
        push_down = np.minimum(np.maximum(multipliers, 0.0), np.abs(self.upper - values))
        push_up = np.minimum(np.maximum(-multipliers, 0.0), np.abs(values - self.lower))
        return float(max(self.violation(x), np.abs(slope).max(), push_down.max(), push_up.max()))


class Solver(Protocol):
    """Solves one program after another."""

    def solve(self, program: Program) -> Vector:
        """Return the optimum x (n,), valid until the next call. Raises UnsolvedError."""


class UnsolvedError(SolverError):
    """A QP without an optimum, with the QP."""

    def __init__(self, message: str, program: Program) -> None:
        super().__init__(message)
        self.program = program
