"""Contacts that come and go, and ticks without a solution."""

import numpy as np
import pytest

from w2c.errors import ControlError, SolverError
from w2c.messages import Array
from w2c_controller.model import ControlledModel
from w2c_controller.parameters import Parameters
from w2c_controller.retargeting import Retargeting
from w2c_controller.solver import Program

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


def test_feet_are_neither_enabled_nor_released(retargeting: Retargeting) -> None:
    with pytest.raises(ValueError, match="left_foot"):
        retargeting.enable(0, np.eye(3))
    with pytest.raises(ValueError, match="right_foot"):
        retargeting.release(1)


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
