"""Each constraint of the Retargeting QP: where it is active, and where it is infeasible."""

from dataclasses import replace

import numpy as np
import pytest

from w2c.messages import Array
from w2c_controller.kinematics.model import ControlledModel
from w2c_controller.parameters import Clamps, Limits, Parameters, Weights
from w2c_controller.seiko.contacts import ContactLayout
from w2c_controller.seiko.program import ProgramBuilder, clamp_norm
from w2c_controller.seiko.retargeting import Retargeting
from w2c_controller.solvers import DaqpSolver, Program, UnsolvedError

LEFT_HAND = 2
RIGHT_HAND = 3


def _built(retargeting: Retargeting, parameters: Parameters | None = None) -> Program:
    """Return the program of the present state."""
    state, kinematics = retargeting.state, retargeting.kinematics
    layout = ContactLayout(state.enabled, retargeting.controlled.nv)
    chosen = parameters or retargeting.parameters
    builder = ProgramBuilder(layout, retargeting.controlled, chosen, retargeting.dt)
    kinematics.update_frames(state.q)
    kinematics.update_statics(state.q, state.wrenches, state.contact_rotations, state.enabled)
    return builder.fill(kinematics, state)


def _pull(retargeting: Retargeting, target: Array, ticks: int) -> None:
    for _ in range(ticks):
        position = retargeting.kinematics.positions[LEFT_HAND]
        lead = clamp_norm(target - position, 0.03)
        retargeting.state.target_positions[LEFT_HAND] = position + lead
        assert retargeting.tick()


def test_standing_still_is_nearly_optimal(retargeting: Retargeting) -> None:
    before = retargeting.state.q.copy()
    for _ in range(100):
        assert retargeting.tick()
    np.testing.assert_allclose(retargeting.kinematics.positions[:2, 2], 0.0, atol=1e-6)
    assert np.abs(retargeting.state.q - before).max() < 0.02


def test_velocity_limit_is_active_on_a_far_pull(retargeting: Retargeting) -> None:
    strong = replace(retargeting.parameters, weights=Weights(hand_position=1e9))
    retargeting.state.target_positions[LEFT_HAND] += [0.04, 0.0, 0.0]
    x = DaqpSolver().solve(_built(retargeting, strong))
    limit = 0.2 * retargeting.controlled.velocity
    limit[retargeting.controlled.balance_joints] *= 0.07 / 0.2
    assert np.all(np.abs(x[6:31]) <= limit + 1e-9)
    assert np.any(np.abs(np.abs(x[6:31]) - limit) < 1e-9)


def test_legs_and_trunk_balance_slowly_while_an_arm_is_fast(retargeting: Retargeting) -> None:
    names = [retargeting.controlled.joint_names[i] for i in retargeting.controlled.balance_joints]

    assert sorted({name.split("_")[0] for name in names}) == ["leg", "torso"]
    assert len(names) == 14


def test_while_a_contact_is_lost_legs_and_trunk_are_as_fast_as_arms(
    retargeting: Retargeting,
) -> None:
    state, robot = retargeting.state.copy(), retargeting.controlled
    builder = ProgramBuilder(
        ContactLayout(state.enabled, robot.nv), robot, retargeting.parameters, 1e-4
    )
    knee = 6 + robot.joint_names.index("leg_left_4_joint")
    fastest = robot.velocity[knee - 6]
    for lost, share in ((False, 0.07), (True, 0.2), (False, 0.07)):
        state.lost[LEFT_HAND] = lost
        program = builder.fill(retargeting.kinematics, state)
        assert program.upper[knee] == pytest.approx(share * fastest)


def test_joint_limits_are_kept_with_their_margin(model: ControlledModel, joints: Array) -> None:
    lean = Retargeting(model, Parameters(), 0.01)
    lean.reset(joints)
    _pull(lean, np.array([0.2, 0.9, 1.9]), 500)
    margin = np.array(
        [
            Limits().joint_margin * Limits().joint_margin_factors.get(n, 1.0)
            for n in model.joint_names
        ]
    )
    q = lean.state.q[7:]
    below, above = q - (model.lower + margin), (model.upper - margin) - q
    started_inside = (joints > model.lower + margin) & (joints < model.upper - margin)
    assert np.all(np.minimum(below, above)[started_inside] > -1e-6)
    assert np.any(np.abs(np.minimum(below, above)) < 1e-3)


def test_centre_of_pressure_ends_a_far_reach(retargeting: Retargeting) -> None:
    _pull(retargeting, np.array([1.6, 0.2, 0.9]), 1500)
    for foot in (0, 1):
        force, torque = retargeting.state.wrenches[foot, :3], retargeting.state.wrenches[foot, 3:]
        pressure = -torque[1] / force[2]
        assert pressure <= Limits().cop_x + 1e-6
        assert pressure == pytest.approx(Limits().cop_x, abs=1e-3)
    com = retargeting.kinematics.center_of_mass(retargeting.state.q)
    assert com[0] == pytest.approx(Limits().cop_x, abs=2e-3)


def test_torque_limits_end_a_motion(model: ControlledModel, joints: Array) -> None:
    weak = Retargeting(model, Parameters(limits=Limits(torque_fraction=0.22)), 0.01)
    weak.reset(joints)
    _pull(weak, np.array([1.4, 0.2, 0.6]), 1000)
    ratio = np.abs(weak.state.torque) / (0.22 * model.effort)
    assert ratio.max() == pytest.approx(1.0, abs=2e-3)


def test_hand_force_grows_at_its_rate_and_ends_at_its_limit(retargeting: Retargeting) -> None:
    retargeting.enable(RIGHT_HAND, np.eye(3))
    forces = []
    for _ in range(100):
        assert retargeting.tick()
        forces.append(retargeting.state.wrenches[RIGHT_HAND, 2])
    assert np.max(np.diff(forces)) <= Limits().hand_force_rate * retargeting.dt + 1e-9
    assert np.max(np.diff(forces)) == pytest.approx(Limits().hand_force_rate * retargeting.dt)
    _pull(retargeting, np.array([1.6, 0.2, 0.9]), 2500)
    assert retargeting.state.wrenches[RIGHT_HAND, 2] <= Limits().hand_force_max + 1e-6


def test_friction_bounds_a_hand_on_a_steep_surface(retargeting: Retargeting) -> None:
    steep = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])  # z ahead
    retargeting.enable(RIGHT_HAND, steep)
    for _ in range(300):
        assert retargeting.tick()
        fx, fy, fz = retargeting.state.wrenches[RIGHT_HAND, :3]
        assert max(abs(fx), abs(fy)) <= Limits().friction * fz + 1e-6


def test_minimum_normal_force_is_kept_once_reached(retargeting: Retargeting) -> None:
    retargeting.enable(RIGHT_HAND, np.eye(3))
    for _ in range(300):
        assert retargeting.tick()
    assert retargeting.loaded(RIGHT_HAND)
    assert retargeting.state.force_min[RIGHT_HAND] == Limits().hand_force_min


def test_an_unbounded_correction_is_infeasible_and_the_bounded_one_is_not(
    retargeting: Retargeting,
) -> None:
    unbounded = Clamps(bias_force=1e3, bias_torque=1e3, bias_position=1.0, bias_rotation=1.0)
    retargeting.state.target_positions[0] += [0.05, 0.0, 0.0]
    with pytest.raises(UnsolvedError):
        DaqpSolver().solve(_built(retargeting, replace(retargeting.parameters, clamps=unbounded)))
    DaqpSolver().solve(_built(retargeting))


def test_a_force_off_equilibrium_is_infeasible_unbounded(retargeting: Retargeting) -> None:
    unbounded = Clamps(bias_force=1e3, bias_torque=1e3, bias_position=1.0, bias_rotation=1.0)
    retargeting.state.wrenches[0, 2] += 20.0
    with pytest.raises(UnsolvedError):
        DaqpSolver().solve(_built(retargeting, replace(retargeting.parameters, clamps=unbounded)))
    DaqpSolver().solve(_built(retargeting))


@pytest.mark.parametrize(("contact", "jump"), [(0, 0.005), (1, -0.005)])
def test_a_moved_contact_is_absorbed(retargeting: Retargeting, contact: int, jump: float) -> None:
    retargeting.state.target_positions[contact, 1] += jump
    for _ in range(600):
        assert retargeting.tick()
    left = retargeting.state.target_positions[contact] - retargeting.kinematics.positions[contact]
    assert np.linalg.norm(left) < 1e-5


def test_a_force_jump_is_absorbed(retargeting: Retargeting) -> None:
    retargeting.state.wrenches[1, 2] -= 20.0
    for _ in range(800):
        assert retargeting.tick()
    assert np.abs(retargeting.kinematics.static[:3]).max() < 1e-2


def test_a_state_beyond_a_joint_limit_is_feasible_and_goes_no_farther(
    model: ControlledModel, joints: Array
) -> None:
    beyond = Retargeting(model, Parameters(limits=Limits(joint_margin=0.75)), 0.01)
    beyond.reset(joints)
    outside = beyond.state.q[7:] > model.upper - 0.75
    assert outside.any()
    for _ in range(50):
        assert beyond.tick()
    grown = beyond.state.q[7:] - joints
    assert np.all(grown[outside] < 1e-9)
