"""The head keeps looking at its point while the body moves."""

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st

from w2c.geometry import Matrix, Vector
from w2c_controller.kinematics.model import build_model
from w2c_controller.motion.gaze import FARTHER, SPEED, Gaze, Neck, fill_neck_angles, find_neck
from w2c_sim_robot.description import make_description

NECK = Neck(
    torso_joint=1,
    torso_from_neck=np.array([0.0, 0.0, 0.3]),
    bus_indices=np.array([0, 1]),
    lower=np.array([-0.26, -1.3]),
    upper=np.array([0.78, 1.3]),
)
DT = 0.002


def axis(angles: Vector) -> Vector:
    """Return the optical axis in the torso, by composing the two rotations."""
    tilt, pan = angles
    return np.asarray(
        pin.rpy.rpyToMatrix(0.0, tilt, 0.0) @ pin.rpy.rpyToMatrix(0.0, 0.0, pan) @ [1.0, 0.0, 0.0]
    )


def settle(gaze: Gaze, rotation: Matrix, position: Vector, *, leaning: bool = False) -> Vector:
    for _ in range(4000):
        gaze.step(rotation, position, leaning=leaning)
    return gaze.angles


@given(st.floats(-0.2, 0.7), st.floats(-1.0, 1.0))
def test_the_angles_of_a_direction_look_along_it(tilt: float, pan: float) -> None:
    direction = axis(np.array([tilt, pan]))
    angles = np.zeros(2)
    x, y, z = (3.0 * float(value) for value in direction)
    fill_neck_angles(x, y, z, angles)
    np.testing.assert_allclose(angles, [tilt, pan], atol=1e-9)


def test_nothing_moves_while_the_body_stands() -> None:
    gaze = Gaze(NECK, np.array([0.7, 0.0]), DT)
    for _ in range(100):
        angles = gaze.step(np.eye(3), np.array([0.0, 0.0, 1.2]), leaning=False)
    np.testing.assert_allclose(angles, [0.7, 0.0], atol=1e-12)


def test_the_axis_goes_through_the_point_again_after_the_torso_bowed_and_turned() -> None:
    gaze = Gaze(NECK, np.array([0.7, 0.0]), DT)
    stand = np.array([0.0, 0.0, 1.2])
    gaze.step(np.eye(3), stand, leaning=False)
    neck = stand + NECK.torso_from_neck
    point = neck + axis(np.array([0.7, 0.0])) * (neck[2] - 0.8) / np.sin(0.7)
    rotation = pin.rpy.rpyToMatrix(0.0, 0.2, 0.3)
    position = np.array([0.1, 0.02, 1.15])
    angles = settle(gaze, rotation, position)
    seen = rotation @ axis(angles)
    there = point - (position + rotation @ NECK.torso_from_neck)
    np.testing.assert_allclose(seen, there / np.linalg.norm(there), atol=1e-6)


def test_a_leaning_robot_looks_farther_ahead() -> None:
    gaze = Gaze(NECK, np.array([0.7, 0.0]), DT)
    near = settle(gaze, np.eye(3), np.array([0.0, 0.0, 1.2]))
    far = settle(gaze, np.eye(3), np.array([0.0, 0.0, 1.2]), leaning=True)
    drop = 0.7
    assert drop / np.tan(far[0]) - drop / np.tan(near[0]) == pytest.approx(FARTHER, abs=1e-6)


def test_the_head_is_no_faster_than_its_limit() -> None:
    gaze = Gaze(NECK, np.array([0.7, 0.0]), DT)
    gaze.step(np.eye(3), np.array([0.0, 0.0, 1.2]), leaning=False)
    before = gaze.angles
    turned = pin.rpy.rpyToMatrix(0.0, 0.0, 1.0)
    after = gaze.step(turned, np.array([0.0, 0.0, 1.2]), leaning=False)
    assert np.abs(after - before).max() <= SPEED * DT + 1e-12


def test_the_joints_stay_within_their_limits_with_the_point_behind() -> None:
    gaze = Gaze(NECK, np.array([0.7, 0.0]), DT)
    gaze.step(np.eye(3), np.array([0.0, 0.0, 1.2]), leaning=False)
    away = pin.rpy.rpyToMatrix(0.0, 0.0, -2.5)
    angles = settle(gaze, away, np.array([0.0, 0.0, 1.2]))
    assert np.all(angles >= NECK.lower)
    assert np.all(angles <= NECK.upper)


def test_the_neck_of_talos_is_found_and_its_axis_is_the_cameras() -> None:
    description = make_description()
    neck = find_neck(description, build_model(description).model)
    assert neck is not None
    names = [description.joints[i].name for i in neck.bus_indices]
    assert names == ["head_1_joint", "head_2_joint"]
    full = pin.buildModelFromXML(description.urdf, pin.JointModelFreeFlyer())
    data = full.createData()
    q = pin.neutral(full)
    angles = np.array([0.4, -0.3])
    for name, angle in zip(names, angles, strict=True):
        q[full.joints[full.getJointId(name)].idx_q] = angle
    pin.framesForwardKinematics(full, data, q)
    camera = data.oMf[full.getFrameId(description.camera_frame)].rotation
    torso = data.oMi[full.parents[full.getJointId("head_1_joint")]].rotation
    np.testing.assert_allclose(torso.T @ camera[:, 2], axis(angles), atol=1e-6)
