"""What an end effector feels, without what it read in the air."""

import numpy as np
import pytest

from w2c_controller.sensing.feelers import Feelers
from w2c_controller.sensing.loads import Measured

LEFT_FOOT, RIGHT_HAND = 0, 3


def measured(foot: tuple[float, float, float], hand: tuple[float, float, float]) -> Measured:
    feet, hands = np.zeros((2, 6)), np.zeros((2, 3))
    feet[0, :3], hands[1] = foot, hand
    return Measured(feet=feet, hands=hands)


def test_what_was_read_in_the_air_is_no_force() -> None:
    feelers = Feelers()
    feelers.expect(RIGHT_HAND, np.array([1.0, 0.0, 0.0]))
    feelers.tare(RIGHT_HAND, measured((0.0, 0.0, 0.0), (2.0, 1.0, 0.0)))
    assert feelers.normal_force(
        RIGHT_HAND, measured((0.0, 0.0, 0.0), (12.0, 1.0, 5.0))
    ) == pytest.approx(10.0)
    beside = measured((0.0, 0.0, 0.0), (2.0, 4.0, 4.0))
    assert feelers.feel(RIGHT_HAND, beside, 10.0, 0.0) == pytest.approx(5.0)


def test_a_foot_feels_along_its_sole() -> None:
    feelers = Feelers()
    feelers.expect(LEFT_FOOT, np.array([0.6, 0.0, 0.8]))
    pressed = measured((3.0, 0.0, 400.0), (0.0, 0.0, 0.0))
    assert feelers.normal_force(LEFT_FOOT, pressed) == 400.0


def test_weight_that_turns_in_the_air_becomes_zero_and_a_bump_does_not() -> None:
    feelers = Feelers()
    turned = measured((0.0, 0.0, 0.0), (0.0, 8.0, 0.0))
    for _ in range(40):
        last = feelers.feel(RIGHT_HAND, turned, 10.0, 0.1)
    assert last < 0.2
    bumped = measured((0.0, 0.0, 0.0), (0.0, 20.0, 0.0))
    for _ in range(40):
        last = feelers.feel(RIGHT_HAND, bumped, 10.0, 0.1)
    assert last == pytest.approx(12.0, abs=0.2)


def test_a_sensor_that_reads_nan_is_never_a_touch() -> None:
    feelers = Feelers()
    broken = measured((0.0, 0.0, 0.0), (np.nan, 0.0, 0.0))
    assert not feelers.feel(RIGHT_HAND, broken, 10.0, 0.1) > 0.0
    assert not feelers.normal_force(RIGHT_HAND, broken) > 0.0
    assert np.isfinite(feelers.tares).all()
