"""The solvers, and what happens when they fail."""

import numpy as np
import pytest

from w2c.errors import SolverError
from w2c_controller.solver import (
    DaqpSolver,
    FallbackSolver,
    PiqpSolver,
    Program,
    Solver,
    UnsolvedError,
)


def _program(lower_row: float = -1.0) -> Program:
    """Return min |x - (2, 2)|^2 / 2 with x0 = x1 / 2, x0 + x1 in [lower_row, 3], x <= 5."""
    program = Program.empty(2, 1, 1)
    program.hessian[:] = np.eye(2)
    program.gradient[:] = -2.0
    program.rows[:] = [[1.0, -0.5], [1.0, 1.0]]
    program.lower[:] = [-5.0, -5.0, 0.0, lower_row]
    program.upper[:] = [5.0, 5.0, 0.0, 3.0]
    return program


@pytest.mark.parametrize("solver", [DaqpSolver(), PiqpSolver(), FallbackSolver()])
def test_optimum_with_an_active_row(solver: Solver) -> None:
    np.testing.assert_allclose(solver.solve(_program()), [1.0, 2.0], atol=1e-7)


@pytest.mark.parametrize("solver", [DaqpSolver(), PiqpSolver(), FallbackSolver()])
def test_an_infeasible_program_raises_with_the_program(solver: Solver) -> None:
    program = _program()
    program.upper[:2] = 0.5
    program.lower[3] = 2.0
    with pytest.raises(UnsolvedError) as caught:
        solver.solve(program)
    assert caught.value.program is program


class _Failing:
    def solve(self, program: Program) -> np.ndarray:
        raise SolverError("always")


def test_the_second_solver_answers_for_the_first() -> None:
    solver = FallbackSolver(first=_Failing())
    np.testing.assert_allclose(solver.solve(_program()), [1.0, 2.0], atol=1e-6)
    assert (solver.fallbacks, solver.failures) == (1, 0)


def test_violation_is_the_worst_of_bounds_and_rows() -> None:
    assert _program().violation(np.array([1.0, 2.0])) == pytest.approx(0.0)
    assert _program().violation(np.array([7.0, 2.0])) == pytest.approx(6.0)
