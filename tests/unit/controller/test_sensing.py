"""Loads from what the robot measures, with and without a sensor at the hand."""

import msgspec
import numpy as np
import pinocchio as pin
import pytest

from w2c.messages import Array, RobotState
from w2c_controller.kinematics.model import ControlledModel, Kinematics, standing_configuration
from w2c_controller.sensing.loads import LoadEstimator

FORCE = np.array([-12.0, 4.0, 55.0])


@pytest.fixture
def state(model: ControlledModel, joints: Array) -> RobotState:
    """Joint torques of a robot at rest whose right hand feels FORCE, the left hand 7 N upwards."""
    n = 27
    kinematics = Kinematics(model)
    q = standing_configuration(model, joints)
    kinematics.update_frames(q)
    gravity = pin.computeGeneralizedGravity(model.model, model.model.createData(), q)
    static = gravity - kinematics.jacobians[3, :3].T @ FORCE
    position, torque = np.zeros(n), np.zeros(n)
    position[model.joint_indices] = joints
    torque[model.joint_indices] = static[6:]
    soles = np.zeros((2, 6))
    soles[:, 2] = [430.0, 450.0]
    wrist = np.zeros(6)
    wrist[:3] = kinematics.rotations[2].T @ [0.0, 0.0, 7.0]
    return RobotState(
        stamp_ns=0,
        tick=0,
        position=position,
        velocity=np.zeros(n),
        torque=torque,
        sole_wrenches=soles,
        left_wrist_wrench=wrist,
        imu_orientation=np.array([0.0, 0.0, 0.0, 1.0]),
        imu_angular_velocity=np.zeros(3),
        imu_linear_acceleration=np.array([0.0, 0.0, 9.81]),
        command=np.zeros(n),
        command_tick=-1,
        mode="tracking",
    )


def test_loads_are_found_in_the_world(model: ControlledModel, state: RobotState) -> None:
    measured = LoadEstimator(model, 0.002).update(state)
    np.testing.assert_allclose(measured.feet[:, 2], [430.0, 450.0])
    np.testing.assert_allclose(measured.hands[0], [0.0, 0.0, 7.0], atol=1e-9)
    np.testing.assert_allclose(measured.hands[1], FORCE, atol=1e-2)
    np.testing.assert_allclose(measured.force(0), [0.0, 0.0, 430.0])
    np.testing.assert_allclose(measured.force(3), measured.hands[1])


def test_end_effectors_are_found_relative_to_each_other(
    model: ControlledModel, joints: Array, state: RobotState
) -> None:
    kinematics = Kinematics(model)
    kinematics.update_frames(standing_configuration(model, joints))
    expected = (kinematics.positions - kinematics.positions[0]) @ kinematics.rotations[0]
    for feet in ((0, 1), (0, 0), (1, 1)):
        measured = LoadEstimator(model, 0.002).update(state, feet)
        found = (measured.positions - measured.positions[0]) @ measured.rotations[0]
        np.testing.assert_allclose(found, expected, atol=1e-9)
    np.testing.assert_allclose(measured.rotations[1], np.eye(3), atol=1e-9)


def test_a_joint_that_reads_nan_makes_no_force(model: ControlledModel, state: RobotState) -> None:
    position = state.position.copy()
    position[3] = np.nan
    estimator = LoadEstimator(model, 0.002)
    broken = estimator.update(msgspec.structs.replace(state, position=position))
    assert np.isnan(broken.hands).all()
    np.testing.assert_allclose(estimator.update(state).hands[1], FORCE, atol=1e-2)
