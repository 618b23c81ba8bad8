"""The solvers, and what happens when they fail."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from w2c.errors import SolverError
from w2c_controller.solvers import (
    ActiveSetSolver,
    DaqpSolver,
    FallbackSolver,
    PiqpSolver,
    Program,
    Solver,
    UnsolvedError,
)
from w2c_controller.solvers.primal_dual import MOST_SETS
from w2c_controller.solvers.structure import Structure


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
    solver = FallbackSolver(solvers=(_Failing(), PiqpSolver()))
    np.testing.assert_allclose(solver.solve(_program()), [1.0, 2.0], atol=1e-6)
    assert (solver.fallbacks, solver.failures) == (1, 0)


def test_violation_is_the_worst_of_bounds_and_rows() -> None:
    assert _program().violation(np.array([1.0, 2.0])) == pytest.approx(0.0)
    assert _program().violation(np.array([7.0, 2.0])) == pytest.approx(6.0)


@st.composite
def convex_programs(draw: st.DrawFn) -> Program:
    """Draw a feasible program with few active bounds, as those of a robot have."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    size = draw(st.integers(2, 30))
    program = Program.empty(size, draw(st.integers(0, size // 2)), draw(st.integers(0, 20)))
    root = rng.standard_normal((size + 2, size))
    program.hessian[:] = root.T @ root + np.eye(size)
    program.rows[:] = rng.standard_normal(program.rows.shape)
    inside = rng.standard_normal(size)
    program.gradient[:] = rng.standard_normal(size) - program.hessian @ inside
    values = np.concatenate([inside, program.rows @ inside])
    program.lower[:] = values - rng.uniform(0.01, 3.0, values.size)
    program.upper[:] = values + rng.uniform(0.01, 3.0, values.size)
    equal = slice(size, size + program.equalities)
    program.lower[equal] = program.upper[equal] = values[equal]
    return program


@settings(max_examples=100)
@given(convex_programs())
def test_the_solvers_agree_and_the_optimum_has_multipliers(program: Program) -> None:
    expected = DaqpSolver().solve(program)
    np.testing.assert_allclose(PiqpSolver().solve(program), expected, atol=1e-3)
    np.testing.assert_allclose(FallbackSolver().solve(program), expected, atol=1e-6)
    warm = ActiveSetSolver()
    np.testing.assert_allclose(warm.solve(program), expected, atol=1e-6)
    assert program.residual(expected, warm.multipliers) < 1e-6
    assert warm.iterations == 1


@settings(max_examples=50)
@given(convex_programs(), st.integers(0, 2**32 - 1))
def test_a_wrong_first_set_is_swapped_or_left_to_the_next_solver(
    program: Program, seed: int
) -> None:
    expected = DaqpSolver().solve(program)
    rng = np.random.default_rng(seed)
    wrong = rng.choice([-1, 0, 0, 0, 0, 0, 0, 1], program.active.size)
    wrong[program.size : program.size + program.equalities] = 0
    program.active[:] = wrong
    np.testing.assert_allclose(FallbackSolver().solve(program), expected, atol=1e-6)


def _corner(seed: int) -> Program:
    """Return a program with many more bounds through its optimum than it has variables."""
    rng = np.random.default_rng(seed)
    size, rows = 6, 24
    program = Program.empty(size, 1, rows)
    root = rng.standard_normal((size + 2, size))
    program.hessian[:] = root.T @ root + np.eye(size)
    program.rows[:] = rng.standard_normal(program.rows.shape)
    program.rows[13:] = program.rows[1:13] * rng.uniform(-2.0, -0.5, (12, 1))
    corner = rng.standard_normal(size)
    values = program.rows @ corner
    program.lower[size], program.upper[size:] = values[0], values
    program.lower[size + 13 :] = program.upper[size + 13 :] - 1.0
    pull = rng.uniform(0.0, 5.0, rows) @ program.rows[1:]
    program.gradient[:] = -program.hessian @ corner - pull
    return program


def test_where_swaps_do_not_end_bounds_join_one_by_one() -> None:
    stepped = 0
    for seed in range(40):
        program, solver = _corner(seed), ActiveSetSolver()
        x = solver.solve(program)
        assert program.residual(x, solver.multipliers) < 1e-6
        stepped += solver.iterations > MOST_SETS
    assert stepped > 10


def test_what_has_no_optimum_is_left_to_the_next_solver() -> None:
    program = Program.empty(3, 0, 3)
    program.hessian[:] = np.eye(3)
    program.gradient[:] = [-1.0, -2.0, -3.0]
    program.rows[:] = [[1.0, 1.0, 0.0], [0.0, 1.0, 1.0], [1.0, 2.0, 1.0]]
    program.upper[3:] = [-1.0, -1.0, 1e30]
    program.lower[5] = -1.0
    with pytest.raises(UnsolvedError, match="no optimum among"):
        ActiveSetSolver().solve(program)
    assert not program.active.any()


def test_a_program_of_limbs_is_solved_as_if_it_had_none() -> None:
    rng = np.random.default_rng(8)
    limbs = [[0, 1, 2, 9], [3, 4, 5]]
    structure = Structure.of_limbs(9, 2, limbs)
    program = Program.empty(9, 2, 1, structure)
    for limb in limbs:
        block = [row for row in limb if row < 9] + [6, 7, 8]
        root = rng.standard_normal((8, len(block)))
        program.hessian[np.ix_(block, block)] += root.T @ root
    program.gradient[:] = rng.standard_normal(9)
    program.rows[0, [0, 1, 2, 8]] = rng.standard_normal(4)
    program.rows[1:] = rng.standard_normal((2, 9))
    program.lower[9:] = program.upper[9:] = [0.3, -0.2, 0.1]
    program.lower[0] = 0.5
    expected = DaqpSolver().solve(program)
    np.testing.assert_allclose(ActiveSetSolver().solve(program), expected, atol=1e-9)
    dense = dataclasses.replace(program, structure=Structure.dense(9, 2))
    np.testing.assert_allclose(ActiveSetSolver().solve(dense), expected, atol=1e-9)


def test_the_active_set_stays_with_the_program() -> None:
    solver, program = ActiveSetSolver(), _program()
    solver.solve(program)
    tried = solver.iterations
    assert program.active.tolist() == [0, 0, 0, 1]
    program.gradient[:] = [-2.1, -1.9]
    np.testing.assert_allclose(solver.solve(program), [1.0, 2.0], atol=1e-12)
    assert solver.iterations == tried + 1


def test_programs_of_one_shape_do_not_share_their_active_sets() -> None:
    """A contact set is left and another one of the same shape taken up."""
    solver, first, second = ActiveSetSolver(), _program(), _program()
    second.upper[3] = 30.0
    np.testing.assert_allclose(solver.solve(first), [1.0, 2.0], atol=1e-12)
    np.testing.assert_allclose(solver.solve(second), [1.2, 2.4], atol=1e-12)
    np.testing.assert_allclose(solver.solve(first), [1.0, 2.0], atol=1e-12)


def test_a_row_given_twice_is_no_obstacle() -> None:
    program = Program.empty(2, 0, 3)
    program.hessian[:] = np.eye(2)
    program.gradient[:] = -2.0
    program.rows[:] = [[1.0, 1.0], [2.0, 2.0], [1.0, -1.0]]
    program.upper[2:] = [3.0, 6.0, 0.0]
    np.testing.assert_allclose(FallbackSolver().solve(program), [1.5, 1.5], atol=1e-7)
    program.active[:] = [0, 0, 1, 1, 1]
    np.testing.assert_allclose(ActiveSetSolver().solve(program), [1.5, 1.5], atol=1e-12)


def test_equalities_that_depend_on_each_other_are_reported() -> None:
    program = Program.empty(2, 2, 0)
    program.hessian[:] = np.eye(2)
    program.rows[:] = [[1.0, 1.0], [2.0, 2.0]]
    program.lower[2:] = program.upper[2:] = [1.0, 2.0]
    with pytest.raises(UnsolvedError, match="depend on each other"):
        ActiveSetSolver().solve(program)


def test_a_cost_that_is_not_convex_is_reported() -> None:
    program = _program()
    program.hessian[0, 0] = -1.0
    with pytest.raises(UnsolvedError, match="convex"):
        ActiveSetSolver().solve(program)


def test_a_nan_is_no_solution() -> None:
    program = _program()
    program.gradient[0] = np.nan
    for solver in (ActiveSetSolver(), DaqpSolver(), FallbackSolver()):
        with pytest.raises(UnsolvedError):
            solver.solve(program)


def test_residual_is_zero_at_an_optimum_only() -> None:
    program = _program()
    multipliers = np.array([0.0, 0.0, 2.0 / 3.0, 1.0 / 3.0])
    assert program.residual(np.array([1.0, 2.0]), multipliers) < 1e-12
    assert program.residual(np.array([1.0, 2.0]), np.zeros(4)) == pytest.approx(1.0)
    assert program.residual(np.array([0.5, 1.0]), multipliers) > 0.1
    assert program.residual(np.array([1.0, 2.0]), -multipliers) > 0.1
