"""Every derivative that the QP uses, against finite differences."""

import numpy as np
import pinocchio as pin
import pytest

from w2c.errors import ConfigError
from w2c.messages import Array, RobotDescription
from w2c_controller.kinematics.model import (
    ControlledModel,
    Kinematics,
    build_model,
    standing_configuration,
)
from w2c_controller.kinematics.momentum import couple_base

STEP = 1e-6
ENABLED = (True, True, True, True)


@pytest.fixture
def posture(model: ControlledModel, joints: Array) -> Array:
    """A posture off every symmetry, base turned too."""
    rng = np.random.default_rng(3)
    q = standing_configuration(model, joints)
    return np.asarray(pin.integrate(model.model, q, 0.1 * rng.standard_normal(model.nv)))


def _wrenches(rng: np.random.Generator) -> tuple[Array, Array]:
    wrenches = 30.0 * rng.standard_normal((4, 6))
    wrenches[2:, 3:] = 0.0
    rotations = np.stack([pin.exp3(rng.standard_normal(3)) for _ in range(4)])
    return wrenches, rotations


def _columns(model: ControlledModel, q: Array, function: object) -> Array:
    columns = []
    for i in range(model.nv):
        step = np.zeros(model.nv)
        step[i] = STEP
        forward = function(pin.integrate(model.model, q, step))  # type: ignore[operator]
        backward = function(pin.integrate(model.model, q, -step))  # type: ignore[operator]
        columns.append((forward - backward) / (2 * STEP))
    return np.stack(columns, axis=-1)


@pytest.mark.parametrize("effector", range(4))
def test_linear_jacobian_is_the_derivative_of_the_position(
    model: ControlledModel, posture: Array, effector: int
) -> None:
    kinematics = Kinematics(model)

    def position(q: Array) -> Array:
        kinematics.update_frames(q)
        return np.array(kinematics.positions[effector])

    numeric = _columns(model, posture, position)
    kinematics.update_frames(posture)
    np.testing.assert_allclose(kinematics.jacobians[effector, :3], numeric, atol=1e-7)


@pytest.mark.parametrize("effector", range(4))
def test_angular_jacobian_is_the_derivative_of_the_rotation(
    model: ControlledModel, posture: Array, effector: int
) -> None:
    kinematics = Kinematics(model)
    kinematics.update_frames(posture)
    reference = kinematics.rotations[effector].copy()
    analytic = kinematics.jacobians[effector, 3:].copy()

    def turn(q: Array) -> Array:
        kinematics.update_frames(q)
        return np.asarray(pin.log3(kinematics.rotations[effector] @ reference.T))

    np.testing.assert_allclose(analytic, _columns(model, posture, turn), atol=1e-7)


def test_statics_derivative_holds_hand_forces_constant_in_the_world(
    model: ControlledModel, posture: Array
) -> None:
    kinematics = Kinematics(model)
    wrenches, rotations = _wrenches(np.random.default_rng(4))

    def static(q: Array) -> Array:
        kinematics.update_frames(q)
        kinematics.update_statics(q, wrenches, rotations, ENABLED)
        return kinematics.static.copy()

    numeric = _columns(model, posture, static)
    static(posture)
    np.testing.assert_allclose(kinematics.static_dq, numeric, atol=2e-4)


def test_statics_are_gravity_minus_the_wrenches_through_the_jacobians(
    model: ControlledModel, posture: Array
) -> None:
    kinematics = Kinematics(model)
    wrenches, rotations = _wrenches(np.random.default_rng(5))
    kinematics.update_frames(posture)
    kinematics.update_statics(posture, wrenches, rotations, ENABLED)
    gravity = pin.computeGeneralizedGravity(model.model, model.model.createData(), posture)
    expected = gravity.copy()
    for foot in (0, 1):
        expected -= kinematics.local_jacobians[foot].T @ wrenches[foot]
    for hand in (2, 3):
        force = rotations[hand] @ wrenches[hand, :3]
        expected -= kinematics.jacobians[hand, :3].T @ force
    np.testing.assert_allclose(kinematics.static, expected, atol=1e-9)


def test_base_coupling_is_that_of_pinocchios_centroidal_map(
    model: ControlledModel, posture: Array
) -> None:
    kinematics = Kinematics(model)
    kinematics.update_frames(posture)
    masses, inertias, sums, columns, coupling = kinematics.in_motion
    bodies = kinematics._bodies
    centers = model.tree.centers
    couple_base(model.tree.parents, masses, centers, inertias, *bodies, sums, columns, coupling)
    centroidal = pin.computeCentroidalMap(model.model, model.model.createData(), posture)
    expected = centroidal.T @ centroidal
    np.testing.assert_allclose(kinematics.base_coupling, expected[:6], atol=1e-9)


def test_integration_is_that_of_pinocchio(model: ControlledModel, posture: Array) -> None:
    rng = np.random.default_rng(6)
    for size in (1e-8, 1e-3, 1.0):
        velocity = size * rng.standard_normal(model.nv)
        expected = pin.integrate(model.model, posture, velocity)
        actual = Kinematics(model).integrate(posture, velocity)
        np.testing.assert_allclose(actual, expected, atol=1e-13)


def test_what_was_read_of_one_posture_survives_the_next(
    model: ControlledModel, posture: Array, joints: Array
) -> None:
    """Pinocchio's own outputs are views of its data."""
    kinematics, other = Kinematics(model), Kinematics(model)
    kinematics.update_frames(posture)
    kept = kinematics.positions.copy()
    other.update_frames(standing_configuration(model, joints))
    np.testing.assert_array_equal(kinematics.positions, kept)
    rotation = kinematics.rotations[2]
    assert rotation.base is kinematics.rotations


def test_standing_puts_the_world_between_the_soles(model: ControlledModel, joints: Array) -> None:
    kinematics = Kinematics(model)
    kinematics.update_frames(standing_configuration(model, joints))
    np.testing.assert_allclose(kinematics.positions[:2].mean(axis=0), np.zeros(3), atol=1e-12)
    np.testing.assert_allclose(kinematics.rotations[:2].mean(axis=0), np.eye(3), atol=1e-9)


def test_the_head_is_not_in_the_qp(model: ControlledModel) -> None:
    assert model.nj == 25
    assert not any(name.startswith("head") for name in model.joint_names)


def test_joints_of_the_right_arm(model: ControlledModel) -> None:
    names = [model.joint_names[i - 6] for i in model.joints_of(3)]
    assert names == [f"arm_right_{i}_joint" for i in range(1, 5)]


def test_a_description_that_is_no_urdf_is_refused(description: RobotDescription) -> None:
    import msgspec

    with pytest.raises(ConfigError, match="URDF"):
        build_model(msgspec.structs.replace(description, urdf="<robot"))


def test_a_frame_that_is_not_in_the_urdf_is_named(description: RobotDescription) -> None:
    import msgspec

    wrong = msgspec.structs.replace(description, hand_frames=("left_hand_frame", "nowhere"))
    with pytest.raises(ConfigError, match="nowhere"):
        build_model(wrong)
