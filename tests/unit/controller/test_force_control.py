"""The flexible robot: its equilibrium, what it follows, contact switches, and failures."""

from dataclasses import replace

import numpy as np
import pytest

from w2c.errors import ControlError, SolverError
from w2c.messages import Array
from w2c_controller.kinematics.model import ControlledModel, Kinematics
from w2c_controller.parameters import Parameters
from w2c_controller.seiko.contacts import contact_sets
from w2c_controller.seiko.flexible_model import FlexibleState, find_equilibrium
from w2c_controller.seiko.force_control import ForceControl
from w2c_controller.seiko.force_parameters import ForceParameters
from w2c_controller.seiko.retargeting import Retargeting
from w2c_controller.sensing.loads import Measured
from w2c_controller.solvers import DaqpSolver, Program

DT = 0.01
RIGHT_HAND = 3
SURFACES = np.tile(np.eye(3), (4, 1, 1))


def as_desired(retargeting: Retargeting) -> Measured:
    """Return measurements of a robot that does what it shall."""
    state, rotations = retargeting.state, retargeting.kinematics.rotations
    hands = np.array([state.world_force(k, rotations) for k in (2, 3)])
    return Measured(feet=state.wrenches[:2].copy(), hands=hands, torque=state.torque.copy())


def springs(model: ControlledModel, state: FlexibleState, command: Array) -> Array:
    """Return what is left of s - S K (theta_cmd - theta) (nv,)."""
    kinematics = Kinematics(model)
    kinematics.update_frames(state.q)
    kinematics.update_statics(state.q, state.wrenches, SURFACES, state.enabled)
    residual = kinematics.static.copy()
    residual[6:] -= model.stiffness * (command - state.q[7:])
    return residual


@pytest.fixture
def control(retargeting: Retargeting) -> ForceControl:
    control = ForceControl(retargeting.controlled, retargeting.parameters, DT)
    control.reset(retargeting)
    return control


def run(retargeting: Retargeting, control: ForceControl, ticks: int) -> None:
    for _ in range(ticks):
        assert retargeting.tick()
        assert control.tick(retargeting, as_desired(retargeting))


def test_no_program_is_made_in_the_loop(
    retargeting: Retargeting, control: ForceControl, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise AssertionError("a program was made in a tick")

    monkeypatch.setattr("w2c_controller.seiko.force_control.FlexibleProgram", refuse)
    assert retargeting.tick()
    for enabled in contact_sets():
        retargeting.state.enabled = enabled
        control.tick(retargeting, as_desired(retargeting))
        assert control.flexible.enabled == enabled


def test_at_reset_the_desired_posture_is_the_equilibrium_of_the_command(
    retargeting: Retargeting, control: ForceControl
) -> None:
    state = control.flexible
    np.testing.assert_array_equal(state.q, retargeting.state.q)
    command = retargeting.state.q[7:] + control.offset
    np.testing.assert_allclose(springs(retargeting.controlled, state, command), 0.0, atol=1e-6)


def test_equilibrium_is_found_from_a_command_without_offset(retargeting: Retargeting) -> None:
    """The robot sags: joints turn by about tau / K, feet stay, and the whole stays in balance."""
    model, desired = retargeting.controlled, retargeting.state
    state = FlexibleState.wound_up(desired, model.stiffness)
    command = desired.q[7:].copy()
    left = find_equilibrium(model, Kinematics(model), state, command, SURFACES)
    assert left < 1e-6
    np.testing.assert_allclose(springs(model, state, command), 0.0, atol=1e-6)
    assert 0.005 < np.abs(state.q[7:] - command).max() < 0.05
    kinematics = Kinematics(model)
    kinematics.update_frames(state.q)
    np.testing.assert_allclose(kinematics.positions[:2], desired.target_positions[:2], atol=1e-9)
    weight = 9.81 * sum(inertia.mass for inertia in model.model.inertias)
    assert state.wrenches[:2, 2].sum() == pytest.approx(weight, rel=1e-3)


def test_no_equilibrium_is_reported(retargeting: Retargeting) -> None:
    model = retargeting.controlled
    state = FlexibleState.wound_up(retargeting.state, model.stiffness)
    command = np.full(model.nj, np.nan)
    with pytest.raises(ControlError, match="equilibrium"):
        find_equilibrium(model, Kinematics(model), state, command, SURFACES)


def test_a_moving_robot_is_followed_in_equilibrium(
    retargeting: Retargeting, control: ForceControl
) -> None:
    for _ in range(200):
        retargeting.state.target_positions[2] = retargeting.kinematics.positions[2]
        retargeting.state.target_positions[2, 0] += 0.002
        run(retargeting, control, 1)
    flexible, desired = control.flexible, retargeting.state
    command = desired.q[7:] + control.offset
    assert np.abs(springs(retargeting.controlled, flexible, command)).max() < 1.0
    np.testing.assert_allclose(flexible.wrenches, desired.wrenches, atol=0.5)
    np.testing.assert_allclose(flexible.q, desired.q, atol=2e-3)


def test_a_leaning_hand_gets_its_force_by_the_offset(
    retargeting: Retargeting, control: ForceControl
) -> None:
    run(retargeting, control, 20)
    before = control.offset.copy()
    retargeting.enable(RIGHT_HAND, np.eye(3))
    run(retargeting, control, 1)
    assert np.abs(control.offset - before).max() < 1e-4
    run(retargeting, control, 300)
    force = retargeting.state.wrenches[RIGHT_HAND, 2]
    assert force > 20.0
    assert control.flexible.wrenches[RIGHT_HAND, 2] == pytest.approx(force, abs=0.5)
    retargeting.release(RIGHT_HAND)
    while retargeting.state.enabled[RIGHT_HAND]:
        before = control.offset.copy()
        run(retargeting, control, 1)
        assert np.abs(control.offset - before).max() < 1e-3
    assert control.flexible.enabled == (True, True, False, False)
    assert not control.flexible.wrenches[RIGHT_HAND].any()


def test_a_force_that_is_too_large_is_taken_back(
    retargeting: Retargeting, control: ForceControl
) -> None:
    run(retargeting, control, 20)
    retargeting.enable(RIGHT_HAND, np.eye(3))
    run(retargeting, control, 450)
    desired = retargeting.state.wrenches[RIGHT_HAND, 2]
    before = control.flexible.wrenches[RIGHT_HAND, 2]
    for _ in range(100):
        retargeting.tick()
        too_large = as_desired(retargeting)
        too_large.hands[1, 2] += 40.0
        control.tick(retargeting, too_large)
    assert retargeting.state.wrenches[RIGHT_HAND, 2] == pytest.approx(desired, abs=0.5)
    assert control.flexible.wrenches[RIGHT_HAND, 2] < before - 2.0


def test_sensors_that_read_nan_leave_the_offset_to_the_model(
    retargeting: Retargeting, control: ForceControl
) -> None:
    run(retargeting, control, 20)
    nothing = Measured(
        feet=np.full((2, 6), np.nan),
        hands=np.full((2, 3), np.nan),
        torque=np.full(retargeting.controlled.nj, np.nan),
    )
    before = control.offset.copy()
    for _ in range(100):
        retargeting.tick()
        assert control.tick(retargeting, nothing)
    np.testing.assert_allclose(control.offset, before, atol=1e-3)


def test_off_means_no_offset(retargeting: Retargeting) -> None:
    parameters = replace(Parameters(), force_control=ForceParameters(mode="off"))
    control = ForceControl(retargeting.controlled, parameters, DT)
    control.reset(retargeting)
    run(retargeting, control, 20)
    assert not control.offset.any()


class FailingSolver:
    """Solves all but some ticks."""

    def __init__(self) -> None:
        self.fails = False

    def solve(self, program: Program) -> Array:
        if self.fails:
            raise SolverError("no solution")
        return DaqpSolver().solve(program)


def test_without_a_solution_the_offset_stays_and_the_next_tick_goes_on(
    retargeting: Retargeting,
) -> None:
    solver = FailingSolver()
    control = ForceControl(retargeting.controlled, retargeting.parameters, DT, solver)
    control.reset(retargeting)
    run(retargeting, control, 20)
    before = control.offset.copy()
    solver.fails = True
    for _ in range(50):
        retargeting.state.target_positions[2] += [0.002, 0.0, 0.0]
        retargeting.tick()
        assert not control.tick(retargeting, as_desired(retargeting))
    np.testing.assert_array_equal(control.offset, before)
    assert control.failures == 50
    solver.fails = False
    run(retargeting, control, 1)
    assert np.abs(control.offset - before).max() < 2e-3
