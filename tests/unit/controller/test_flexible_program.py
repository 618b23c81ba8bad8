"""The Controller QP: its derivatives, and each constraint where it is active and where it fails."""

from dataclasses import replace

import numpy as np
import pytest

from w2c.messages import Array
from w2c_controller.kinematics.model import Kinematics
from w2c_controller.parameters import Clamps, Parameters
from w2c_controller.seiko.contacts import ContactLayout
from w2c_controller.seiko.flexible_model import FlexibleState
from w2c_controller.seiko.flexible_program import FlexibleProgram
from w2c_controller.seiko.force_parameters import FlexibleWeights, ForceParameters
from w2c_controller.seiko.retargeting import Retargeting
from w2c_controller.solvers import DaqpSolver, Program, UnsolvedError

DT = 0.01
RIGHT_HAND = 3
KNEE = 3


class Setup:
    """A program of the flexible robot in the desired equilibrium, to be disturbed."""

    def __init__(self, retargeting: Retargeting, parameters: Parameters | None = None) -> None:
        self.retargeting = retargeting
        self.controlled = retargeting.controlled
        self.parameters = parameters or Parameters()
        self.kinematics = Kinematics(self.controlled)
        self.state = FlexibleState.wound_up(retargeting.state, self.controlled.stiffness)
        self.effort_rates = np.zeros((4, 6))
        self.torque_limits = self.controlled.effort.copy()
        layout = ContactLayout(retargeting.state.enabled, self.controlled.nv)
        self.builder = FlexibleProgram(layout, self.controlled, self.parameters, DT)
        self.desired_joints = retargeting.state.q[7:].copy()

    @property
    def command(self) -> Array:
        return np.asarray(self.desired_joints + self.state.offset)

    def program(self) -> Program:
        state, surfaces = self.state, self.retargeting.state.contact_rotations
        self.kinematics.update_frames(state.q)
        self.kinematics.update_statics(state.q, state.wrenches, surfaces, state.enabled)
        return self.builder.fill(
            self.kinematics,
            state,
            self.retargeting.kinematics,
            self.command,
            self.effort_rates,
            self.torque_limits,
        )

    def solve(self) -> Array:
        return DaqpSolver().solve(self.program())

    def lag(self) -> Array:
        """Return d = K^-1 (s_J - K (theta_cmd - theta)) (nj,), on its own path."""
        state, surfaces = self.state, self.retargeting.state.contact_rotations
        self.kinematics.update_frames(state.q)
        self.kinematics.update_statics(state.q, state.wrenches, surfaces, state.enabled)
        wound = self.command - state.q[7:]
        return np.asarray(self.kinematics.static[6:] / self.controlled.stiffness - wound)

    def static(self) -> Array:
        self.lag()
        return self.kinematics.static.copy()

    def move(self, x: Array, step: float) -> None:
        """Move posture and wrenches along x."""
        nv = self.controlled.nv
        self.state.q = self.kinematics.integrate(self.state.q, step * x[:nv])
        for k, where in self.builder.layout.slices.items():
            self.state.wrenches[k, : where.stop - where.start] += step * x[where]

    def command_rows(self) -> slice:
        start = self.builder.layout.equality_rows
        return slice(start, start + self.controlled.nj)


@pytest.fixture
def leaning(retargeting: Retargeting) -> Retargeting:
    """A desired state that leans on its right hand."""
    for _ in range(50):
        retargeting.tick()
    turned = np.array([[0.8, 0.0, 0.6], [0.0, 1.0, 0.0], [-0.6, 0.0, 0.8]])
    retargeting.enable(RIGHT_HAND, turned)
    for _ in range(200):
        assert retargeting.tick()
    retargeting.kinematics.update_frames(retargeting.state.q)
    return retargeting


def test_standing_in_equilibrium_asks_for_nothing(retargeting: Retargeting) -> None:
    setup = Setup(retargeting)
    x = setup.solve()
    np.testing.assert_allclose(setup.builder.command_rate(x), 0.0, atol=1e-4)
    np.testing.assert_allclose(x[setup.controlled.nv :], 0.0, atol=0.05)


def test_command_map_is_the_derivative_of_the_flexible_equilibrium(leaning: Retargeting) -> None:
    """D x is how fast theta_cmd must change so that springs and statics stay in balance."""
    rng = np.random.default_rng(0)
    setup = Setup(leaning)
    setup.state.wrenches[:2] += rng.normal(0.0, 20.0, (2, 6))
    size = setup.builder.layout.size
    rows = setup.program().rows[setup.command_rows()].copy()
    step = 1e-6
    for _ in range(8):
        # Feet and the hand turn little about their contacts: what the map neglects is J' dlambda.
        x = rng.normal(0.0, 1.0, size)
        values = []
        for sign in (1.0, -1.0):
            moved = Setup(leaning)
            moved.state.wrenches = setup.state.wrenches.copy()
            moved.move(x, sign * step)
            values.append(moved.lag())
        derivative = (values[0] - values[1]) / (2 * step)
        np.testing.assert_allclose(rows @ x, derivative, rtol=1e-5, atol=1e-5)


def test_static_rows_are_the_derivative_of_the_residual(leaning: Retargeting) -> None:
    rng = np.random.default_rng(1)
    setup = Setup(leaning)
    program = setup.program()
    nj, equalities = setup.controlled.nj, program.equalities
    rows = np.vstack([program.rows[equalities - 6 : equalities], program.rows[equalities + nj :]])
    for _ in range(8):
        x = rng.normal(0.0, 1.0, program.size)
        values = []
        for sign in (1.0, -1.0):
            moved = Setup(leaning)
            moved.move(x, sign * 1e-6)
            values.append(moved.static())
        derivative = (values[0] - values[1]) / 2e-6
        np.testing.assert_allclose(rows @ x, derivative, rtol=1e-5, atol=1e-2)


def test_effort_rates_are_followed_where_balance_allows(leaning: Retargeting) -> None:
    setup = Setup(leaning)
    at_rest = setup.solve()
    setup.effort_rates[RIGHT_HAND, 2] = 10.0
    hand = setup.builder.layout.slices[RIGHT_HAND]
    rates = setup.solve()[hand] - at_rest[hand]
    assert rates[2] == pytest.approx(10.0, abs=3.0)


def test_contacts_stay_and_the_base_keeps_its_balance(leaning: Retargeting) -> None:
    setup = Setup(leaning)
    setup.effort_rates[:] = 20.0
    x = setup.solve()
    jacobians, nv = setup.kinematics.jacobians, setup.controlled.nv
    for k, size in ((0, 6), (1, 6), (RIGHT_HAND, 3)):
        speed = jacobians[k, :size] @ x[:nv]
        assert np.abs(speed[:3]).max() <= Clamps().bias_position / DT + 1e-9
    setup.move(x, DT)
    assert np.abs(setup.static()[:6]).max() < 0.5


def test_the_bias_of_a_moved_contact_is_bounded(retargeting: Retargeting) -> None:
    setup = Setup(retargeting)
    setup.state.contact_positions[0] += [0.05, 0.0, 0.0]
    x = setup.solve()
    speed = setup.kinematics.jacobians[0, :3] @ x[: setup.controlled.nv]
    assert speed[0] == pytest.approx(Clamps().bias_position / DT, rel=1e-3)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_offset_keeps_its_limit(leaning: Retargeting, sign: float) -> None:
    setup = Setup(leaning)
    setup.effort_rates[RIGHT_HAND, 2] = 2000.0 * sign
    free = setup.builder.command_rate(setup.solve())
    joint = int(np.argmax(np.abs(free)))
    limit = abs(setup.state.offset[joint]) + 0.3 * DT * abs(free[joint])
    parameters = Parameters(force_control=ForceParameters(offset_limit=float(limit)))
    bounded = Setup(leaning, parameters)
    bounded.effort_rates[RIGHT_HAND, 2] = 2000.0 * sign
    after = bounded.state.offset + DT * bounded.builder.command_rate(bounded.solve())
    started_inside = np.abs(bounded.state.offset) < limit
    assert np.abs(after[started_inside]).max() == pytest.approx(limit, abs=1e-9)


def test_the_command_keeps_joint_limits(leaning: Retargeting) -> None:
    setup = Setup(leaning)
    setup.effort_rates[RIGHT_HAND, 2] = 2000.0
    rate = setup.builder.command_rate(setup.solve())
    joint = int(np.argmax(np.abs(rate)))
    edge = setup.command[joint] + 0.3 * DT * rate[joint]
    controlled = setup.controlled
    lower, upper = controlled.lower.copy(), controlled.upper.copy()
    (upper if rate[joint] > 0 else lower)[joint] = edge
    limits = replace(Parameters().limits, joint_margin=0.0)
    narrow = Setup(leaning, Parameters(limits=limits))
    narrow.controlled = replace(controlled, lower=lower, upper=upper)
    layout = ContactLayout(leaning.state.enabled, controlled.nv)
    narrow.builder = FlexibleProgram(layout, narrow.controlled, narrow.parameters, DT)
    narrow.effort_rates[RIGHT_HAND, 2] = 2000.0
    after = narrow.command + DT * narrow.builder.command_rate(narrow.solve())
    assert after[joint] == pytest.approx(edge, abs=1e-9)


def test_torques_keep_their_limits(leaning: Retargeting) -> None:
    setup = Setup(leaning)
    setup.effort_rates[RIGHT_HAND, 2] = 500.0
    before = setup.static()[6:]
    free = setup.program().rows[setup.builder.layout.equality_rows + setup.controlled.nj :]
    rates = free @ setup.solve()
    arm = setup.controlled.joints_of(RIGHT_HAND) - 6
    joint = int(arm[np.argmax(np.abs(rates[arm]))])
    setup.torque_limits[joint] = abs(before[joint]) + 0.3 * DT * abs(rates[joint])
    program = setup.program()
    after = before + DT * program.rows[program.equalities + setup.controlled.nj :] @ setup.solve()
    assert abs(after[joint]) <= setup.torque_limits[joint] + 1e-6


def test_a_state_beyond_its_limits_is_not_thrown_back(leaning: Retargeting) -> None:
    setup = Setup(leaning)
    setup.torque_limits[:] = 1.0
    setup.state.offset[KNEE] += 1.0
    setup.desired_joints[KNEE] -= 1.0
    program = setup.program()
    rows = slice(program.equalities, None)
    at = slice(program.size + program.equalities, None)
    assert np.all(program.lower[at] <= 0.0)
    assert np.all(program.upper[at] >= 0.0)
    x = setup.solve()
    assert np.all(program.rows[rows] @ x <= program.upper[at] + 1e-6)


@pytest.mark.parametrize("part", ["contact", "balance", "command", "torque"])
def test_a_constraint_that_cannot_hold_is_reported(retargeting: Retargeting, part: str) -> None:
    setup = Setup(retargeting)
    program = setup.program()
    nj, equalities = setup.controlled.nj, program.equalities
    first = {
        "contact": 0,
        "balance": equalities - 6,
        "command": equalities,
        "torque": equalities + nj,
    }[part]
    # The same row once more, with bounds that exclude its own.
    again = equalities + 1
    program.rows[again] = program.rows[first]
    program.lower[program.size + again] = program.upper[program.size + first] + 1.0
    program.upper[program.size + again] = program.upper[program.size + first] + 2.0
    with pytest.raises(UnsolvedError):
        DaqpSolver().solve(program)


def test_free_hands_go_where_the_desired_posture_has_them(retargeting: Retargeting) -> None:
    weights = FlexibleWeights(hand_position=1e6)
    parameters = Parameters(force_control=ForceParameters(weights=weights))
    setup = Setup(retargeting, parameters)
    retargeting.kinematics.positions[2] += [0.001, 0.0, 0.0]
    x = setup.solve()
    speed = setup.kinematics.jacobians[2, :3] @ x[: setup.controlled.nv]
    assert speed[0] == pytest.approx(0.001 / DT, rel=0.1)
