"""What stands between a target and the QP."""

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from w2c.messages import Array
from w2c_controller.motion.blend import Blend
from w2c_controller.motion.filters import bang_bang_speed, low_pass_gain
from w2c_controller.motion.pose_filters import PoseFilters
from w2c_controller.parameters import Filters

DT = 0.002


def test_low_pass_halves_power_at_its_cutoff() -> None:
    alpha = low_pass_gain(2.0, DT)
    z = np.exp(2j * np.pi * 2.0 * DT)
    gain = abs((1 - alpha) / (1 - alpha / z))
    assert gain == pytest.approx(1 / np.sqrt(2), abs=0.01)


@settings(max_examples=30)
@given(st.floats(-0.5, 0.5), st.floats(-0.2, 0.2))
def test_bang_bang_arrives_within_its_limits_without_overshoot(start: float, speed: float) -> None:
    position, moving = start, speed if start * speed < 0.0 else 0.0
    overshoot = max(moving**2 / (2 * 2.0) - abs(start), 0.0)
    for _ in range(4000):
        before = moving
        moving = bang_bang_speed(-position, moving, 0.2, 2.0, DT)
        assert abs(moving) <= 0.2 + 1e-12
        assert abs(moving - before) <= 2.0 * DT + 1e-12
        position += DT * moving
        if position * start < 0.0:
            assert abs(position) <= overshoot + 1e-3
    assert abs(position) < 1e-5


class _Filtered:
    """Filters of four end effectors that the desired posture has at one place."""

    def __init__(self, place: Array) -> None:
        self.places = np.tile(place, (4, 1))
        self.level = np.tile(np.eye(3), (4, 1, 1))
        self.filters = PoseFilters(Filters(), DT, np.zeros((4, 3)), self.level)
        self.positions, self.rotations = np.zeros((4, 3)), self.level.copy()
        self.displacements = np.zeros((4, 3))

    def step(
        self, targets: Array, wanted: Array, enabled: tuple[bool, bool, bool, bool] = (False,) * 4
    ) -> None:
        self.filters.step(
            enabled,
            targets,
            wanted,
            self.displacements,
            self.places,
            self.level,
            self.positions,
            self.rotations,
        )


def test_the_command_leads_the_hand_by_a_bounded_distance() -> None:
    filtered, filters = _Filtered(np.zeros(3)), Filters()
    targets = np.tile([5.0, 0.0, 0.0], (4, 1))
    turned = np.tile(pin.exp3(np.array([0.0, 0.0, 2.0])), (4, 1, 1))
    for _ in range(3000):
        filtered.step(targets, turned)
    for k in range(4):
        lead = np.linalg.norm(filtered.positions[k])
        assert lead == pytest.approx(filters.lead_position, abs=1e-4)
        turn = np.linalg.norm(pin.log3(filtered.rotations[k]))
        assert turn == pytest.approx(filters.lead_rotation, abs=1e-3)


def test_a_filter_that_was_reset_stays() -> None:
    where = np.array([0.3, 0.2, 0.9])
    filtered = _Filtered(where)
    for k in range(4):
        filtered.filters.reset(k, filtered.places, filtered.level)
    filtered.step(filtered.places, filtered.level)
    np.testing.assert_allclose(filtered.positions, filtered.places, atol=1e-15)


def test_a_contact_keeps_its_target_and_starts_from_rest_when_it_is_freed() -> None:
    where = np.array([0.3, 0.2, 0.9])
    filtered = _Filtered(where)
    filtered.displacements[2] = 0.01
    targets = filtered.places + np.array([0.0, 0.0, 0.02])
    for _ in range(100):
        filtered.step(targets, filtered.level, (True, True, True, False))
    np.testing.assert_array_equal(filtered.positions[:3], 0.0)
    filtered.step(targets, filtered.level, (True, True, False, False))
    assert np.linalg.norm(filtered.positions[2] - where) < 1e-4
    np.testing.assert_array_equal(filtered.displacements[2], 0.0)


def test_displacements_act_behind_the_filter() -> None:
    filtered = _Filtered(np.zeros(3))
    filtered.displacements[3] = [0.0, 0.0, 0.01]
    filtered.step(np.zeros((4, 3)), filtered.level)
    np.testing.assert_allclose(filtered.positions[3], [0.0, 0.0, 0.01])


def test_a_blend_begins_at_the_command_in_force_and_ends_at_its_own() -> None:
    blend = Blend(np.array([1.0]), 2.0, DT)
    values = []
    while not blend.done:
        blend.advance()
        values.append(float(blend.mix(np.array([2.0]))[0]))
    assert values[0] == pytest.approx(1.0, abs=1e-5)
    assert values[-1] == 2.0
    assert np.max(np.diff(values)) <= 1.5 / 2.0 * DT + 1e-9
