"""Free hands and feet give way to forces, and come back."""

import numpy as np
import pytest

from w2c.messages import Array
from w2c_controller.motion.pose_filters import PoseFilters
from w2c_controller.parameters import Filters
from w2c_controller.seiko.force_parameters import ForceParameters
from w2c_controller.sensing.admittance import Admittance
from w2c_controller.sensing.loads import Measured

DT = 0.008
STANDING = (True, True, False, False)
ON_ONE_FOOT = (True, False, False, False)
UPRIGHT = np.tile(np.eye(3), (4, 1, 1))


def measured(left: Array | None = None, foot: Array | None = None) -> Measured:
    feet, hands = np.zeros((2, 6)), np.zeros((2, 3))
    if left is not None:
        hands[0] = left
    if foot is not None:
        feet[1, :3] = foot
    return Measured(feet=feet, hands=hands)


def pushed(
    admittance: Admittance, force: Measured, seconds: float, enabled: tuple[bool, ...] = STANDING
) -> Array:
    for _ in range(round(seconds / DT)):
        admittance.step(force, UPRIGHT, enabled)  # type: ignore[arg-type]
    return admittance.displacements.copy()


@pytest.fixture
def admittance() -> Admittance:
    started = Admittance(ForceParameters(), DT)
    pushed(started, measured(), 0.1)
    return started


def test_a_hand_gives_way_with_the_published_gain(admittance: Admittance) -> None:
    """20 N are 10 N beyond the deadband: 3 cm/s."""
    way = pushed(admittance, measured(np.array([-20.0, 0.0, 0.0])), 1.0)
    np.testing.assert_allclose(way[2], [-0.03, 0.0, 0.0], atol=1e-3)
    assert not way[[0, 1, 3]].any()


def test_a_hand_gives_way_no_faster_than_its_limit_and_not_for_ever(
    admittance: Admittance,
) -> None:
    way = pushed(admittance, measured(np.array([0.0, 0.0, 500.0])), 0.5)
    assert way[2, 2] == pytest.approx(0.05, abs=1e-3)
    way = pushed(admittance, measured(np.array([0.0, 0.0, 500.0])), 5.0)
    assert way[2, 2] == pytest.approx(0.1)


def test_a_touch_is_not_evaded(admittance: Admittance) -> None:
    """Switching takes 10 N for a touch: up to there the hand holds against the surface."""
    assert not pushed(admittance, measured(np.array([0.0, 0.0, 9.9])), 0.2).any()


def test_the_target_comes_back_when_the_force_is_gone(admittance: Admittance) -> None:
    pushed(admittance, measured(np.array([0.0, 40.0, 0.0])), 0.5)
    way = pushed(admittance, measured(), 1.0)
    assert way[2, 1] == pytest.approx(0.045 - 0.02, abs=1e-3)
    assert not pushed(admittance, measured(), 3.0)[2].any()


def test_a_mass_in_the_hand_is_its_zero() -> None:
    admittance = Admittance(ForceParameters(), DT)
    weight = np.array([0.0, 0.0, -98.1])
    assert not pushed(admittance, measured(weight), 5.0).any()
    assert pushed(admittance, measured(np.array([20.0, 0.0, -98.1])), 1.0)[2, 0] > 0.02


def test_a_slow_drift_becomes_the_zero_and_a_push_does_not(admittance: Admittance) -> None:
    for force in np.linspace(0.0, 30.0, 2000):
        way = pushed(admittance, measured(np.array([force, 0.0, 0.0])), DT)
    assert not way.any()
    way = pushed(admittance, measured(np.array([50.0, 0.0, 0.0])), 1.0)
    assert way[2, 0] > 0.02


def test_a_contact_does_not_give_way(admittance: Admittance) -> None:
    leaning = (True, True, True, False)
    assert not pushed(admittance, measured(np.array([0.0, 0.0, 80.0])), 1.0, leaning).any()


def test_a_foot_in_the_air_gives_way_in_the_world(admittance: Admittance) -> None:
    """70 N in the frame of a sole that is turned by a quarter: 20 N beyond the deadband."""
    turned = UPRIGHT.copy()
    turned[1] = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    admittance.step(measured(), turned, ON_ONE_FOOT)
    for _ in range(125):
        force = measured(foot=np.array([70.0, 0.0, 0.0]))
        admittance.step(force, turned, ON_ONE_FOOT)
    np.testing.assert_allclose(admittance.displacements[1], [0.0, 0.01, 0.0], atol=1e-3)


def test_a_sensor_that_reads_nan_holds(admittance: Admittance) -> None:
    before = pushed(admittance, measured(np.array([0.0, 40.0, 0.0])), 0.5)
    after = pushed(admittance, measured(np.array([np.nan, 40.0, 0.0])), 0.5)
    np.testing.assert_array_equal(after, before)


def test_without_force_control_nothing_gives_way() -> None:
    admittance = Admittance(ForceParameters(mode="off"), DT)
    pushed(admittance, measured(), 0.1)
    assert not pushed(admittance, measured(np.array([0.0, 0.0, 80.0])), 1.0).any()


def test_a_target_that_gave_way_does_not_carry_its_filter_off() -> None:
    positions, rotations = np.zeros((4, 3)), UPRIGHT.copy()
    filters = PoseFilters(Filters(), 0.002, positions, rotations)
    displacements = np.zeros((4, 3))
    displacements[2, 0] = -0.08
    targets, reached, turned = np.zeros((4, 3)), positions.copy(), rotations.copy()
    for _ in range(1000):
        filters.step(STANDING, targets, rotations, displacements, reached, turned, reached, turned)
    np.testing.assert_allclose(reached[2], [-0.08, 0.0, 0.0], atol=1e-12)
