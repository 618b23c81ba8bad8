"""Filters of the force feedback, sensors that fail, and torque limits with hysteresis."""

from dataclasses import replace

import numpy as np
import pytest

from w2c.messages import Array
from w2c_controller.seiko.desired import DesiredState
from w2c_controller.seiko.force_feedback import TorqueLimits, WrenchFeedback
from w2c_controller.seiko.force_parameters import ForceParameters
from w2c_controller.sensing.loads import Measured

DT = 0.002
LEANING = (True, True, False, True)
STILL = np.zeros((4, 6))
PLAIN = ForceParameters(proportional=0.2, damping=0.0, complementary_hz=0.2, fade_in=0.0)


@pytest.fixture
def desired() -> DesiredState:
    state = DesiredState(q=np.zeros(32), posture=np.zeros(25), enabled=LEANING)
    state.wrenches[:2, 2] = 400.0
    state.wrenches[3, 2] = 50.0
    state.contact_rotations[3] = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]
    return state


def measured(desired: DesiredState, hand: float = 50.0) -> Measured:
    """Return wrenches as desired, but for the normal force of the right hand."""
    hands = np.zeros((2, 3))
    hands[1] = hand * desired.contact_rotations[3, :, 2]
    return Measured(feet=desired.wrenches[:2].copy(), hands=hands)


def started(desired: DesiredState, parameters: ForceParameters = PLAIN) -> WrenchFeedback:
    feedback = WrenchFeedback(parameters, DT)
    feedback.reset(desired)
    feedback.switch(desired.enabled)
    return feedback


def test_wrenches_as_desired_ask_for_nothing(desired: DesiredState) -> None:
    feedback = started(desired)
    for _ in range(100):
        feedback.step(desired, measured(desired), STILL)
    np.testing.assert_allclose(feedback.effort_rates, 0.0, atol=1e-9)


def test_the_desired_rate_is_passed_on(desired: DesiredState) -> None:
    feedback = started(desired)
    feedback.step(desired, measured(desired), STILL)
    desired.wrenches[0, 2] += 60.0 * DT
    feedback.step(desired, measured(desired), STILL)
    assert feedback.effort_rates[0, 2] == pytest.approx(60.0, abs=0.1)


def test_a_missing_force_is_asked_for_in_the_contacts_frame(desired: DesiredState) -> None:
    feedback = started(desired)
    for _ in range(3):
        feedback.step(desired, measured(desired, hand=20.0), STILL)
    np.testing.assert_allclose(feedback.effort_rates[3], [0, 0, 6.0, 0, 0, 0], atol=0.05)


def test_the_feedback_of_a_new_contact_fades_in(desired: DesiredState) -> None:
    feedback = started(desired, replace(PLAIN, fade_in=2.0))
    for _ in range(2000):
        feedback.step(desired, measured(desired, hand=20.0), STILL)
    assert feedback.effort_rates[3, 2] == pytest.approx(6.0, abs=0.1)
    feedback.switch((True, True, False, False))
    feedback.switch(LEANING)
    for ticks, rate in ((1, 0.0), (249, 1.5), (250, 3.0), (500, 6.0), (500, 6.0)):
        for _ in range(ticks):
            feedback.step(desired, measured(desired, hand=20.0), STILL)
        assert feedback.effort_rates[3, 2] == pytest.approx(rate, abs=0.05)


def test_damping_has_the_sign_it_is_given(desired: DesiredState) -> None:
    for damping in (0.02, -0.02):
        feedback = started(desired, replace(PLAIN, proportional=0.0, damping=damping))
        for tick in range(200):
            feedback.step(desired, measured(desired, hand=50.0 + 100.0 * DT * tick), STILL)
        assert feedback.rates[3, 2] == pytest.approx(100.0, rel=0.01)
        assert feedback.effort_rates[3, 2] == pytest.approx(damping * 100.0, rel=0.01)


def test_the_estimate_is_the_model_first_and_the_sensor_in_the_end(desired: DesiredState) -> None:
    """Cut at 0.2 Hz: half of a step of the model is forgotten after 0.55 s."""
    feedback = started(desired)
    feedback.step(desired, measured(desired), STILL)
    rates = STILL.copy()
    rates[3, 2] = 100.0
    for _ in range(50):
        feedback.step(desired, measured(desired), rates)
    assert feedback.believed[3, 2] == pytest.approx(60.0, abs=0.7)
    for _ in range(276):
        feedback.step(desired, measured(desired), STILL)
    assert feedback.believed[3, 2] == pytest.approx(55.0, abs=0.7)
    for _ in range(2000):
        feedback.step(desired, measured(desired), STILL)
    assert feedback.believed[3, 2] == pytest.approx(50.0, abs=0.05)


def test_a_new_contact_begins_with_what_is_measured(desired: DesiredState) -> None:
    desired.enabled = (True, True, False, False)
    feedback = started(desired)
    for _ in range(10):
        feedback.step(desired, measured(desired, hand=0.0), STILL)
    desired.enabled = LEANING
    feedback.switch(LEANING)
    feedback.step(desired, measured(desired, hand=12.0), STILL)
    assert feedback.believed[3, 2] == pytest.approx(12.0)
    feedback.step(desired, measured(desired, hand=40.0), STILL)
    assert feedback.believed[3, 2] == pytest.approx(12.0, abs=0.1)


def test_a_sensor_that_reads_nan_leaves_its_contact_to_the_model(desired: DesiredState) -> None:
    feedback = started(desired, replace(PLAIN, damping=0.02))
    for tick in range(100):
        feedback.step(desired, measured(desired, hand=50.0 + tick), STILL)
    broken = measured(desired)
    broken.hands[1, 1] = np.nan
    before = feedback.believed[3, 2]
    rates = STILL.copy()
    rates[3, 2] = 10.0
    for _ in range(100):
        feedback.step(desired, broken, rates)
        assert np.isfinite(feedback.effort_rates).all()
    assert feedback.believed[3, 2] == pytest.approx(before + 100 * DT * 10.0)
    assert feedback.rates[3, 2] == 0.0
    for _ in range(4000):
        feedback.step(desired, measured(desired, hand=45.0), STILL)
    assert feedback.believed[3, 2] == pytest.approx(45.0, abs=0.1)


def test_a_nan_of_one_contact_does_not_touch_another(desired: DesiredState) -> None:
    whole, broken = started(desired), started(desired)
    for _ in range(50):
        reading = measured(desired, hand=30.0)
        whole.step(desired, reading, STILL)
        reading = measured(desired, hand=30.0)
        reading.feet[0, 5] = np.nan
        broken.step(desired, reading, STILL)
    np.testing.assert_array_equal(whole.effort_rates[1:], broken.effort_rates[1:])


@pytest.fixture
def effort() -> Array:
    return np.array([100.0, 50.0])


def settled(limits: TorqueLimits, measured: Array, model: Array, seconds: float = 1.0) -> None:
    for _ in range(round(seconds / DT)):
        limits.step(measured, model)


def test_a_torque_limit_shrinks_above_one_ratio_and_grows_below_another(effort: Array) -> None:
    limits = TorqueLimits(ForceParameters(), effort, DT)
    model = np.array([60.0, 5.0])
    settled(limits, np.array([74.0, 5.0]), model)
    np.testing.assert_array_equal(limits.limits, effort)
    settled(limits, np.array([76.0, 5.0]), model)
    np.testing.assert_allclose(limits.limits, [61.0, 50.0])
    settled(limits, np.array([70.0, 5.0]), model)
    np.testing.assert_allclose(limits.limits, [61.0, 50.0])
    settled(limits, np.array([60.0, 5.0]), model, seconds=1.5)
    assert 65.0 < limits.limits[0] < 76.0
    settled(limits, np.array([60.0, 5.0]), model, seconds=5.0)
    np.testing.assert_array_equal(limits.limits, effort)


def test_a_torque_limit_follows_the_model_down_only(effort: Array) -> None:
    limits = TorqueLimits(ForceParameters(), effort, DT)
    overloaded = np.array([90.0, 5.0])
    settled(limits, overloaded, np.array([60.0, 5.0]))
    settled(limits, overloaded, np.array([-40.0, 5.0]))
    assert limits.limits[0] == pytest.approx(41.0)
    settled(limits, overloaded, np.array([70.0, 5.0]))
    assert limits.limits[0] == pytest.approx(41.0)


def test_a_joint_that_reads_nan_keeps_its_limit(effort: Array) -> None:
    limits = TorqueLimits(ForceParameters(), effort, DT)
    model = np.array([60.0, 5.0])
    settled(limits, np.array([90.0, 5.0]), model)
    settled(limits, np.array([np.nan, 45.0]), model)
    np.testing.assert_allclose(limits.limits, [61.0, 6.0])


def test_a_spike_of_torque_changes_nothing(effort: Array) -> None:
    limits = TorqueLimits(ForceParameters(), effort, DT)
    model = np.array([60.0, 5.0])
    settled(limits, np.array([60.0, 5.0]), model)
    settled(limits, np.array([100.0, 5.0]), model, seconds=0.02)
    np.testing.assert_array_equal(limits.limits, effort)


def test_without_torque_limits_any_torque_is_allowed(effort: Array) -> None:
    limits = TorqueLimits(ForceParameters(mode="no_torque_limit"), effort, DT)
    settled(limits, effort, effort)
    assert np.isinf(limits.limits).all()
