"""What stands between a target and the QP."""

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from w2c_controller.filters import Blend, HandFilter, LowPass, bang_bang_speed, low_pass_gain
from w2c_controller.parameters import Filters

DT = 0.002


def test_low_pass_passes_a_constant_and_halves_power_at_its_cutoff() -> None:
    alpha = low_pass_gain(2.0, DT)
    z = np.exp(2j * np.pi * 2.0 * DT)
    gain = abs((1 - alpha) / (1 - alpha / z))
    assert gain == pytest.approx(1 / np.sqrt(2), abs=0.01)
    low_pass = LowPass(2.0, DT)
    assert float(low_pass.step(np.array([3.0]))[0]) == 3.0


def test_a_nan_passes_the_low_pass_and_is_forgotten() -> None:
    low_pass = LowPass(2.0, DT)
    low_pass.step(np.array([1.0]))
    assert np.isnan(low_pass.step(np.array([np.nan]))).all()
    assert float(low_pass.step(np.array([1.0]))[0]) == 1.0


@settings(max_examples=30, deadline=None)
@given(st.floats(-0.5, 0.5), st.floats(-0.2, 0.2))
def test_bang_bang_arrives_within_its_limits_without_overshoot(start: float, speed: float) -> None:
    position, moving = np.array([start]), np.array([0.0 if start == 0.0 else speed])
    moving = np.where(np.sign(moving) == -np.sign(position), moving, 0.0)
    stopping = float(moving[0] ** 2) / (2 * 2.0)
    overshoot = max(stopping - abs(start), 0.0)
    for _ in range(4000):
        before = moving
        moving = bang_bang_speed(-position, moving, 0.2, 2.0, DT)
        assert abs(float(moving[0])) <= 0.2 + 1e-12
        assert abs(float((moving - before)[0])) <= 2.0 * DT + 1e-12
        position = position + DT * moving
        if np.sign(position[0]) == -np.sign(start):
            assert abs(float(position[0])) <= overshoot + 1e-3
    assert abs(float(position[0])) < 1e-5


def test_the_command_leads_the_hand_by_a_bounded_distance() -> None:
    hand, filters = np.zeros(3), Filters()
    hand_filter = HandFilter(filters, DT, hand, np.eye(3))
    turned = pin.exp3(np.array([0.0, 0.0, 2.0]))
    for _ in range(3000):
        hand_filter.step(np.array([5.0, 0.0, 0.0]), turned, hand, np.eye(3))
    assert np.linalg.norm(hand_filter.position) == pytest.approx(filters.lead_position, abs=1e-4)
    turn = np.linalg.norm(pin.log3(hand_filter.rotation))
    assert turn == pytest.approx(filters.lead_rotation, abs=1e-3)


def test_a_filter_that_was_reset_stays() -> None:
    where = np.array([0.3, 0.2, 0.9])
    hand_filter = HandFilter(Filters(), DT, np.zeros(3), np.eye(3))
    hand_filter.reset(where, np.eye(3))
    hand_filter.step(where, np.eye(3), where, np.eye(3))
    np.testing.assert_allclose(hand_filter.position, where, atol=1e-15)


def test_a_blend_begins_at_the_command_in_force_and_ends_at_its_own() -> None:
    blend = Blend(np.array([1.0]), 2.0, DT)
    values = []
    while not blend.done:
        blend.advance()
        values.append(float(blend.mix(np.array([2.0]))[0]))
    assert values[0] == pytest.approx(1.0, abs=1e-5)
    assert values[-1] == 2.0
    assert np.max(np.diff(values)) <= 1.5 / 2.0 * DT + 1e-9
