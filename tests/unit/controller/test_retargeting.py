"""Contacts that come and go, and ticks without a solution."""

import numpy as np
import pytest

from w2c.errors import ControlError, SolverError
from w2c.messages import Array
from w2c_controller.kinematics.model import ControlledModel
from w2c_controller.parameters import Parameters
from w2c_controller.seiko.retargeting import Retargeting
from w2c_controller.solvers import Program

RIGHT_HAND = 3


def test_feet_carry_the_weight_at_the_start(retargeting: Retargeting) -> None:
    mass = sum(inertia.mass for inertia in retargeting.controlled.model.inertias)
    total = retargeting.state.wrenches[:2, 2].sum()
    assert total == pytest.approx(9.81 * mass, rel=1e-6)
    assert np.abs(retargeting.kinematics.static[:6]).max() < 1e-6


def test_a_posture_that_would_fall_is_refused(model: ControlledModel, joints: Array) -> None:
    leaning = joints.copy()
    for i, name in enumerate(model.joint_names):
        if name.endswith("leg_left_5_joint") or name.endswith("leg_right_5_joint"):
            leaning[i] += 0.5
    with pytest.raises(ControlError, match="cannot stand"):
        Retargeting(model, Parameters(), 0.01).reset(leaning)


def test_a_released_hand_is_free_when_its_force_is_gone(retargeting: Retargeting) -> None:
    retargeting.enable(RIGHT_HAND, np.eye(3))
    for _ in range(200):
        retargeting.tick()
    assert retargeting.loaded(RIGHT_HAND)
    retargeting.release(RIGHT_HAND)
    forces = []
    while retargeting.state.enabled[RIGHT_HAND]:
        assert retargeting.tick()
        forces.append(retargeting.state.wrenches[RIGHT_HAND, 2])
        assert len(forces) < 1000
    assert forces[-2] < 0.2
    assert not retargeting.state.releasing[RIGHT_HAND]


def push(retargeting: Retargeting, force: float) -> None:
    """Let the right hand bear a force along the normal [N]."""
    retargeting.enable(RIGHT_HAND, np.eye(3))
    retargeting.state.pushing[RIGHT_HAND] = True
    retargeting.state.push_force[RIGHT_HAND] = force
    rate = retargeting.parameters.limits.hand_force_rate * retargeting.dt
    for _ in range(round(force / rate) + 100):
        assert retargeting.tick()
    assert retargeting.state.wrenches[RIGHT_HAND, 2] == pytest.approx(force, abs=1.0)


def test_the_force_of_a_lost_hand_goes_at_once_and_the_feet_take_it(
    retargeting: Retargeting,
) -> None:
    state, kinematics = retargeting.state, retargeting.kinematics
    push(retargeting, 60.0)
    weight = state.wrenches[:, 2].sum()
    retargeting.release(RIGHT_HAND, lost=True)
    ticks = 0
    while state.enabled[RIGHT_HAND]:
        assert retargeting.tick()
        assert np.abs(kinematics.static[:6]).max() < 5.0
        ticks += 1
        assert ticks * retargeting.dt < 0.3
    assert state.wrenches[:2, 2].sum() == pytest.approx(weight, abs=1.0)
    feet = state.wrenches[:2].copy()
    limits = retargeting.parameters.limits
    for _ in range(20):
        assert retargeting.tick()
        rates = np.abs(state.wrenches[:2] - feet) / retargeting.dt
        assert rates[:, :3].max() <= limits.foot_force_rate + 1e-6
        assert rates[:, 3:].max() <= limits.foot_torque_rate + 1e-6
        feet = state.wrenches[:2].copy()


def test_a_lost_hand_that_is_kept_unloads_as_ever_the_next_time(retargeting: Retargeting) -> None:
    state = retargeting.state
    push(retargeting, 20.0)
    retargeting.release(RIGHT_HAND, lost=True)
    retargeting.keep(RIGHT_HAND)
    retargeting.release(RIGHT_HAND)
    before = state.wrenches[RIGHT_HAND, 2]
    assert retargeting.tick()
    slowest = retargeting.parameters.limits.hand_force_rate * retargeting.dt
    assert before - state.wrenches[RIGHT_HAND, 2] <= slowest + 1e-9


def test_a_foot_is_unloaded_lifted_put_down_and_loaded(retargeting: Retargeting) -> None:
    retargeting.release(0)
    ticks = 0
    while retargeting.state.enabled[0]:
        assert retargeting.tick()
        ticks += 1
        assert ticks < 1500
    weight = float(retargeting.state.wrenches[1, 2])
    assert weight == pytest.approx(sum(retargeting.state.wrenches[:, 2]))
    # The balance is over the other sole: within the half width of its centre of pressure.
    com = retargeting.kinematics.center_of_mass(retargeting.state.q)
    assert abs(com[1] - retargeting.kinematics.positions[1, 1]) < 0.031
    retargeting.state.target_positions[0, 2] += 0.03
    for _ in range(200):
        assert retargeting.tick()
    assert retargeting.kinematics.positions[0, 2] == pytest.approx(0.03, abs=2e-3)
    retargeting.state.target_positions[0, 2] -= 0.03
    for _ in range(200):
        assert retargeting.tick()
    retargeting.enable(0, np.eye(3))
    for _ in range(180):
        assert retargeting.tick()
    assert retargeting.loaded(0)


def test_the_wrench_of_a_released_foot_shrinks_as_a_whole_and_no_joint_races(
    retargeting: Retargeting,
) -> None:
    state = retargeting.state
    push(retargeting, 40.0)
    whole = state.wrenches[0].copy()
    assert np.abs(whole[3:]).max() > 1.0
    retargeting.release(0)
    for _ in range(100):
        assert retargeting.tick()
        assert np.abs(state.velocity[6:]).max() < 0.1
    share = state.wrenches[0, 2] / whole[2]
    assert share == pytest.approx(1.0 - 60.0 * 100 * retargeting.dt / whole[2], abs=0.01)
    np.testing.assert_allclose(state.wrenches[0], share * whole, atol=0.05)


def test_the_last_foot_is_never_dropped(retargeting: Retargeting) -> None:
    retargeting.release(0)
    retargeting.release(1)
    for _ in range(1000):
        assert retargeting.tick()
    assert retargeting.state.enabled[:2] == (True, True)


class _Failing:
    def __init__(self) -> None:
        self.programs: list[Program] = []

    def solve(self, program: Program) -> Array:
        self.programs.append(program)
        raise SolverError("no")


def test_without_a_solution_the_robot_holds_and_it_is_counted(retargeting: Retargeting) -> None:
    before = retargeting.state.q.copy()
    retargeting._solver = _Failing()
    assert not retargeting.tick()
    np.testing.assert_array_equal(retargeting.state.q, before)
    np.testing.assert_array_equal(retargeting.state.velocity, 0.0)
    assert retargeting.failures == 1


def test_a_copy_is_independent(retargeting: Retargeting) -> None:
    copy = retargeting.state.copy()
    retargeting.state.target_positions[2, 0] += 0.1
    for _ in range(20):
        retargeting.tick()
    assert np.abs(copy.q - retargeting.state.q).max() > 1e-4
    assert copy.target_positions[2, 0] != retargeting.state.target_positions[2, 0]


def test_what_is_a_contact_already_is_not_enabled_again(retargeting: Retargeting) -> None:
    with pytest.raises(ControlError, match="left_foot is a contact already; release it"):
        retargeting.enable(0, np.eye(3))
    retargeting.enable(RIGHT_HAND, np.eye(3))
    with pytest.raises(ControlError, match="right_hand"):
        retargeting.enable(RIGHT_HAND, np.eye(3))


def test_a_hand_in_push_mode_tracks_its_force_along_the_normal(retargeting: Retargeting) -> None:
    retargeting.enable(RIGHT_HAND, np.eye(3))
    state = retargeting.state
    state.pushing[RIGHT_HAND] = True
    state.push_force[RIGHT_HAND] = 25.0
    rates = []
    for _ in range(500):
        before = state.wrenches[RIGHT_HAND, 2]
        assert retargeting.tick()
        rates.append((state.wrenches[RIGHT_HAND, 2] - before) / retargeting.dt)
    assert max(rates) == pytest.approx(10.0, abs=1e-6)
    np.testing.assert_allclose(state.wrenches[RIGHT_HAND, :3], [0.0, 0.0, 25.0], atol=1e-2)
    state.pushing[RIGHT_HAND] = False
    for _ in range(500):
        assert retargeting.tick()
    assert abs(state.wrenches[RIGHT_HAND, 2] - 25.0) > 1.0


def test_a_push_beyond_the_limit_of_the_hand_ends_there(retargeting: Retargeting) -> None:
    retargeting.enable(RIGHT_HAND, np.eye(3))
    retargeting.state.pushing[RIGHT_HAND] = True
    retargeting.state.push_force[RIGHT_HAND] = 1e3
    for _ in range(2000):
        assert retargeting.tick()
    highest = retargeting.parameters.limits.hand_force_max
    assert retargeting.state.wrenches[RIGHT_HAND, 2] <= highest + 1e-6
