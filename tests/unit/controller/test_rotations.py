"""Rotation vectors against Pinocchio's."""

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st

from w2c.messages import Array
from w2c_controller.kinematics.rotations import rotation_between, rotation_vector, turn

number = st.floats(-1.0, 1.0)


@given(st.tuples(number, number, number), st.floats(0.0, np.pi - 1e-6))
def test_log_and_exp_are_inverse_and_those_of_pinocchio(
    axis: tuple[float, float, float], angle: float
) -> None:
    length = float(np.linalg.norm(axis))
    vector = np.array(axis) * (angle / length) if length > 1e-3 else np.zeros(3)
    rotation, back = np.eye(3), np.zeros(3)
    turn(rotation, *(float(x) for x in vector))
    np.testing.assert_allclose(rotation, pin.exp3(vector), atol=1e-14)
    rotation_vector(rotation, back)
    np.testing.assert_allclose(back, vector, atol=1e-9)
    np.testing.assert_allclose(back, pin.log3(rotation), atol=1e-7)


@pytest.mark.parametrize("axis", [*np.eye(3), np.array([0.6, 0.0, -0.8])])
def test_half_a_turn_has_its_axis(axis: Array) -> None:
    back = np.zeros(3)
    rotation_vector(pin.exp3(np.pi * axis), back)
    np.testing.assert_allclose(np.abs(back @ axis), np.pi, atol=1e-9)


@given(st.integers(0, 2**32 - 1))
def test_the_turn_between_two_rotations_leads_from_one_to_the_other(seed: int) -> None:
    rng = np.random.default_rng(seed)
    start, end = (pin.exp3(rng.standard_normal(3)) for _ in range(2))
    between = np.zeros(3)
    rotation_between(end, start, between)
    np.testing.assert_allclose(between, pin.log3(end @ start.T), atol=1e-7)
    turn(start, *(float(x) for x in between))
    np.testing.assert_allclose(start, end, atol=1e-9)
