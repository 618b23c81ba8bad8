"""A ball in contact rolls: the point that touches is at rest, and the force acts there."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pinocchio as pin
import pytest

from w2c.messages import Array
from w2c_controller.kinematics.model import ControlledModel, Kinematics, standing_configuration
from w2c_controller.parameters import Parameters
from w2c_controller.seiko.flexible_model import FlexibleState, find_equilibrium
from w2c_controller.seiko.force_control import ForceControl
from w2c_controller.seiko.retargeting import Retargeting
from w2c_controller.seiko.rolling import roll
from w2c_controller.sensing.loads import Measured

STEP = 1e-6
DT = 0.01
ALL = (True, True, True, True)
LEFT_HAND, RIGHT_HAND = 2, 3
RADIUS = 0.05
TURNED = np.array([[0.8, 0.0, 0.6], [0.0, 1.0, 0.0], [-0.6, 0.0, 0.8]])
"""world_from_contact of a surface that slopes"""
NORMAL = TURNED[:, 2]
BALL = np.array([[3, 31, 3]])
"""A table of contacts that holds the right hand alone"""


@pytest.fixture(scope="module")
def posture(model: ControlledModel, joints: Array) -> Array:
    rng = np.random.default_rng(3)
    q = standing_configuration(model, joints)
    return np.asarray(pin.integrate(model.model, q, 0.1 * rng.standard_normal(model.nv)))


@pytest.fixture(scope="module")
def levers() -> Array:
    levers = np.zeros((4, 3))
    levers[2:] = 0.05 * np.random.default_rng(1).standard_normal((2, 3))
    return levers


@pytest.fixture(scope="module")
def loads() -> tuple[Array, Array]:
    """Wrenches (4, 6) and world_from_contact (4, 3, 3)."""
    rng = np.random.default_rng(2)
    wrenches = 30.0 * rng.standard_normal((4, 6))
    wrenches[2:, 3:] = 0.0
    return wrenches, np.stack([pin.exp3(rng.standard_normal(3)) for _ in range(4)])


def columns(model: ControlledModel, q: Array, function: object) -> Array:
    """Return the central differences (m, nv) of a function of the posture."""
    steps = STEP * np.eye(model.nv)
    return np.stack(
        [
            (
                function(pin.integrate(model.model, q, step))  # type: ignore[operator]
                - function(pin.integrate(model.model, q, -step))  # type: ignore[operator]
            )
            / (2 * STEP)
            for step in steps
        ],
        axis=-1,
    )


@pytest.mark.parametrize("hand", [LEFT_HAND, RIGHT_HAND])
def test_the_jacobian_is_that_of_the_point_of_the_body_that_touches(
    model: ControlledModel,
    posture: Array,
    levers: Array,
    loads: tuple[Array, Array],
    hand: int,
) -> None:
    kinematics = Kinematics(model)
    kinematics.update_statics(posture, *loads, ALL, levers)
    in_body = kinematics.rotations[hand].T @ levers[hand]

    def point(q: Array) -> Array:
        kinematics.update_frames(q)
        return np.asarray(kinematics.positions[hand] + kinematics.rotations[hand] @ in_body)

    numeric = columns(model, posture, point)
    kinematics.update_statics(posture, *loads, ALL, levers)
    np.testing.assert_allclose(kinematics.point_jacobians[hand - 2], numeric, atol=1e-7)


def test_statics_are_those_of_a_force_at_the_lever_constant_in_the_world(
    model: ControlledModel, posture: Array, levers: Array, loads: tuple[Array, Array]
) -> None:
    """The lever does not turn with the hand: the touching point is always the lowest of a ball."""
    wrenches, rotations = loads
    kinematics = Kinematics(model)

    def static(q: Array) -> Array:
        kinematics.update_statics(q, wrenches, rotations, ALL, levers)
        return kinematics.static.copy()

    numeric = columns(model, posture, static)
    expected = pin.computeGeneralizedGravity(model.model, model.model.createData(), posture)
    static(posture)
    for foot in (0, 1):
        expected -= kinematics.local_jacobians[foot].T @ wrenches[foot]
    for hand in (2, 3):
        force = rotations[hand] @ wrenches[hand, :3]
        expected -= kinematics.point_jacobians[hand - 2].T @ force
        np.testing.assert_allclose(
            kinematics.static_dl[hand, :, :3],
            -kinematics.point_jacobians[hand - 2].T @ rotations[hand],
            atol=1e-12,
        )
    np.testing.assert_allclose(kinematics.static, expected, atol=1e-9)
    np.testing.assert_allclose(kinematics.static_dq, numeric, atol=2e-4)


def test_without_levers_the_numbers_are_those_of_points_to_the_last_bit(
    model: ControlledModel, posture: Array, loads: tuple[Array, Array]
) -> None:
    plain, levered = Kinematics(model), Kinematics(model)
    plain.update_statics(posture, *loads, ALL)
    levered.update_statics(posture, *loads, ALL, np.zeros((4, 3)))
    np.testing.assert_array_equal(levered.point_jacobians, plain.jacobians[2:, :3])
    np.testing.assert_array_equal(levered.static_dq, plain.static_dq)


def test_a_ball_that_turns_rolls_along_the_plane_and_back() -> None:
    jacobians = np.zeros((4, 6, 3))
    jacobians[RIGHT_HAND, 3:] = np.eye(3)
    supports = np.tile(np.arange(3), (4, 1))
    levers = np.zeros((4, 3))
    levers[RIGHT_HAND] = [0.0, 0.0, -RADIUS]
    places = np.ones((4, 3))
    for turn, way in (([0.0, 0.4, 0.0], [0.02, 0, 0]), ([0.4, 0.0, 0.0], [0, -0.02, 0])):
        before = places.copy()
        roll(1.0, np.array(turn), jacobians, supports, levers, BALL, places)
        np.testing.assert_allclose(places[RIGHT_HAND] - before[RIGHT_HAND], way, atol=1e-15)
        roll(0.5, -2.0 * np.array(turn), jacobians, supports, levers, BALL, places)
        np.testing.assert_allclose(places, before, atol=1e-15)
    roll(1.0, np.array([0.0, 0.0, 1.0]), jacobians, supports, levers, BALL, places)
    np.testing.assert_allclose(places, np.ones((4, 3)), atol=1e-15)


def lean_and_swing(model: ControlledModel, joints: Array) -> tuple[Array, Array]:
    """Lean on the right hand, move the left there and back; returns its centres and rotations."""
    leaning = Retargeting(model, Parameters(), DT)
    leaning.reset(joints)
    leaning.enable(RIGHT_HAND, TURNED)
    assert all(leaning.tick() for _ in range(150))
    centres, rotations = [], []
    for tick in range(400):
        way = 0.001 if tick < 200 else -0.001
        leaning.state.target_positions[LEFT_HAND] += [way, 0.5 * way, way]
        assert leaning.tick()
        leaning.kinematics.update_frames(leaning.state.q)
        centres.append(leaning.kinematics.positions[RIGHT_HAND].copy())
        rotations.append(leaning.kinematics.rotations[RIGHT_HAND].copy())
    return np.array(centres), np.array(rotations)


def test_a_leaning_ball_rolls_without_slip_and_comes_back_with_the_arm(
    model: ControlledModel, joints: Array
) -> None:
    centres, rotations = lean_and_swing(model, joints)
    turns = [pin.log3(b @ a.T) for a, b in pairwise(rotations)]
    rolled = np.cumsum(np.cross(turns, RADIUS * NORMAL), axis=0)
    way = centres - centres[0]
    assert np.abs(way).max() > 3e-3
    np.testing.assert_allclose(way[1:], rolled, atol=3e-5)
    np.testing.assert_allclose(way @ NORMAL, 0.0, atol=3e-5)
    assert np.linalg.norm(way[-1]) < 0.5 * np.linalg.norm(way, axis=1).max()


def test_a_hand_without_radius_stays_where_it_is(model: ControlledModel, joints: Array) -> None:
    centres, _ = lean_and_swing(replace(model, hand_radius=(0.0, 0.0)), joints)
    np.testing.assert_allclose(centres - centres[0], 0.0, atol=3e-5)


def test_the_flexible_ball_rolls_too(model: ControlledModel, joints: Array) -> None:
    leaning = Retargeting(model, Parameters(), DT)
    leaning.reset(joints)
    leaning.enable(RIGHT_HAND, TURNED)
    assert all(leaning.tick() for _ in range(150))
    desired, kinematics = leaning.state, Kinematics(model)
    state = FlexibleState.wound_up(desired, model.stiffness)
    command = desired.q[7:] + state.offset + 0.01 * np.sin(np.arange(model.nj))
    before, place = Kinematics(model), state.contact_positions[RIGHT_HAND].copy()
    before.update_frames(state.q)
    left = find_equilibrium(
        model, kinematics, state, command, desired.contact_rotations, desired.levers
    )
    assert left < 1e-3
    way = state.contact_positions[RIGHT_HAND] - place
    turn = pin.log3(kinematics.rotations[RIGHT_HAND] @ before.rotations[RIGHT_HAND].T)
    assert np.linalg.norm(way) > 1e-4
    np.testing.assert_allclose(way, np.cross(turn, RADIUS * NORMAL), atol=5e-6)
    np.testing.assert_allclose(
        kinematics.positions[RIGHT_HAND], state.contact_positions[RIGHT_HAND], atol=1e-6
    )


def test_desired_and_flexible_ball_roll_alike(model: ControlledModel, joints: Array) -> None:
    leaning = Retargeting(model, Parameters(), DT)
    leaning.reset(joints)
    control = ForceControl(model, Parameters(), DT)
    control.reset(leaning)
    leaning.enable(RIGHT_HAND, TURNED)
    begun = leaning.state.target_positions[RIGHT_HAND].copy()
    for _ in range(150):
        leaning.state.target_positions[LEFT_HAND] += [0.001, 0.0, 0.001]
        assert leaning.tick()
        state, rotations = leaning.state, leaning.kinematics.rotations
        hands = np.array([state.world_force(k, rotations) for k in (2, 3)])
        as_desired = Measured(feet=state.wrenches[:2], hands=hands, torque=state.torque)
        assert control.tick(leaning, as_desired)
    desired = leaning.state.target_positions[RIGHT_HAND] - begun
    assert np.linalg.norm(desired) > 1e-3
    flexible = control.flexible.contact_positions[RIGHT_HAND]
    np.testing.assert_allclose(flexible, leaning.state.target_positions[RIGHT_HAND], atol=5e-4)
