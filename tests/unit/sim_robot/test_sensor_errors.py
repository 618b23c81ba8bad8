"""Sensors err as they are told to, and the same seed gives the same errors."""

from typing import Any

import msgspec
import numpy as np
import pytest

from w2c.errors import ConfigError
from w2c.geometry import rotation_from_quaternion
from w2c.messages import Array
from w2c_sim_robot.imperfection import Imperfection
from w2c_sim_robot.sensing import Channels
from w2c_sim_robot.sensor_errors import (
    ForceTorqueErrors,
    ImuErrors,
    JointErrors,
    SensorErrors,
    combine,
    typical,
)

CHANNELS = Channels(4)
PERIOD_S = 0.002
UPRIGHT = (0.0, 0.0, 0.0, 1.0)


def truth(value: float = 0.0) -> Array:
    """Return what ideal sensors read when everything is one number."""
    reading = np.full(CHANNELS.width, value)
    reading[CHANNELS.orientation] = UPRIGHT
    return reading


def make(errors: SensorErrors, seed: int = 0) -> Imperfection:
    return Imperfection(errors, CHANNELS, np.random.default_rng(seed), period_s=PERIOD_S)


def read(sensors: Imperfection, ticks: int, first: int = 0) -> Array:
    """Return what is read (ticks, width) when the truth is the first, then one more each tick."""
    return np.array([sensors.read(truth(float(first + tick))).copy() for tick in range(ticks)])


def errors_of(errors: SensorErrors, ticks: int = 2000, seed: int = 0) -> Array:
    """Return readings less the truth (ticks, width), all zero but for the orientation."""
    sensors = make(errors, seed)
    return np.array([sensors.read(truth()) - truth() for _ in range(ticks)])


def test_encoders_of_the_perception_benchmark() -> None:
    """0.02 degrees of noise, and a constant bias of up to 0.05 degrees a joint."""
    noise, bias = np.radians(0.02), np.radians(0.05)
    found = errors_of(SensorErrors(position=JointErrors(noise=noise, bias=bias)))
    angles = found[:, CHANNELS.position]
    assert angles.std(axis=0) == pytest.approx(np.full(4, noise), rel=0.08)
    means = angles.mean(axis=0)
    assert np.abs(means).max() < bias + 4 * noise / np.sqrt(len(found))
    assert np.abs(means).max() > 0.1 * bias
    assert len(set(np.round(means, 9))) == 4
    others = np.delete(found, range(4), axis=1)
    assert np.abs(others).max() == 0.0


FORCE = CHANNELS.wrenches.start


@pytest.mark.parametrize(
    ("errors", "noisy"),
    [
        (SensorErrors(velocity=JointErrors(noise=2.0)), [*range(4, 8)]),
        (SensorErrors(torque=JointErrors(noise=2.0)), [*range(8, 12)]),
        (
            SensorErrors(soles=ForceTorqueErrors(force_noise=2.0)),
            [FORCE + i for i in (0, 1, 2, 6, 7, 8)],
        ),
        (
            SensorErrors(wrist=ForceTorqueErrors(moment_noise=2.0)),
            [FORCE + i for i in (15, 16, 17)],
        ),
        (SensorErrors(imu=ImuErrors(angular_velocity_noise=2.0)), [16, 17, 18]),
        (SensorErrors(imu=ImuErrors(acceleration_noise=2.0)), [19, 20, 21]),
    ],
)
def test_noise_is_zero_mean_and_reaches_its_values_alone(
    errors: SensorErrors, noisy: list[int]
) -> None:
    found = errors_of(errors)
    assert np.flatnonzero(found.any(axis=0)).tolist() == noisy
    assert found[:, noisy].std() == pytest.approx(2.0, rel=0.05)
    assert found[:, noisy].mean() == pytest.approx(0.0, abs=0.1)


@pytest.mark.parametrize(
    ("errors", "biased"),
    [
        (SensorErrors(soles=ForceTorqueErrors(moment_bias=3.0)), [3, 4, 5, 9, 10, 11]),
        (SensorErrors(wrist=ForceTorqueErrors(force_bias=3.0)), [12, 13, 14]),
    ],
)
def test_bias_is_constant_and_within_its_bound(errors: SensorErrors, biased: list[int]) -> None:
    found = errors_of(errors, 5)
    assert (found == found[0]).all()
    assert np.flatnonzero(found[0]).tolist() == [FORCE + index for index in biased]
    assert np.abs(found[0]).max() <= 3.0
    assert not np.array_equal(found[0], errors_of(errors, 1, seed=1)[0])


def test_orientation_errs_by_turns_and_stays_a_unit_quaternion() -> None:
    deviation = 0.01
    sensors = make(SensorErrors(imu=ImuErrors(orientation_noise=deviation)))
    read = np.array([sensors.read(truth())[CHANNELS.orientation].copy() for _ in range(2000)])
    assert np.linalg.norm(read, axis=1) == pytest.approx(np.ones(len(read)))
    assert (2.0 * read[:, :3]).std(axis=0) == pytest.approx(np.full(3, deviation), rel=0.08)
    askew = make(SensorErrors(imu=ImuErrors(orientation_bias=0.1)))
    first = askew.read(truth())[CHANNELS.orientation].copy()
    assert 0.0 < 2.0 * np.arccos(first[3]) <= 0.1 * np.sqrt(3)
    assert askew.read(truth())[CHANNELS.orientation].tolist() == first.tolist()
    lying = truth()
    lying[CHANNELS.orientation] = (0.1, -0.5, 0.7, 0.5)  # of unit length
    seen = rotation_from_quaternion(askew.read(lying)[CHANNELS.orientation])
    expected = rotation_from_quaternion((0.1, -0.5, 0.7, 0.5)) @ rotation_from_quaternion(first)
    assert seen == pytest.approx(expected)


def test_delay_shows_what_was_and_the_start_before_there_was_anything() -> None:
    errors = SensorErrors(position=JointErrors(delay_ms=6.0), soles=ForceTorqueErrors(delay_ms=2.0))
    found = read(make(errors), 8, first=5)
    assert found[:, 0].tolist() == [5.0, 5.0, 5.0, 5.0, 6.0, 7.0, 8.0, 9.0]
    assert found[:, FORCE].tolist() == [5.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0]
    assert found[:, 4].tolist() == [5.0 + tick for tick in range(8)]


def test_what_does_not_arrive_is_read_again_device_by_device() -> None:
    errors = SensorErrors(velocity=JointErrors(dropout=0.3), soles=ForceTorqueErrors(dropout=0.3))
    found = read(make(errors), 2000)
    ticks = np.arange(2000)
    for column in (4, FORCE, FORCE + 6):
        lost = found[1:, column] != ticks[1:]
        assert lost.mean() == pytest.approx(0.3, abs=0.04)
        assert (found[1:, column][lost] == found[:-1, column][lost]).all()
    assert (found[:, 4] == found[:, 7]).all()
    assert not np.array_equal(found[:, FORCE], found[:, FORCE + 6])  # each foot for itself
    assert (found[:, 0] == ticks).all()


def test_same_seed_same_errors_and_a_reset_begins_anew() -> None:
    errors = combine(typical(), SensorErrors(position=JointErrors(bias=1.0, dropout=0.2)))
    one, other = make(errors, 5), make(errors, 5)
    first = read(one, 50)
    assert read(other, 50).tobytes() == first.tobytes()
    one.reset()
    assert read(one, 50).tobytes() == first.tobytes()
    assert read(make(errors, 6), 50).tobytes() != first.tobytes()


def test_the_noise_of_a_sensor_does_not_depend_on_the_others() -> None:
    encoder = JointErrors(noise=1.0)
    alone = read(make(SensorErrors(position=encoder)), 20)
    together = read(
        make(SensorErrors(position=encoder, imu=ImuErrors(acceleration_noise=1.0, dropout=0.5))), 20
    )
    assert alone[:, :4].tolist() == together[:, :4].tolist()


def test_no_errors_no_difference() -> None:
    sensors = make(SensorErrors())
    reading = np.random.default_rng(0).normal(size=CHANNELS.width)
    assert sensors.read(reading).tolist() == reading.tolist()


def test_combining_keeps_the_first_where_it_says_something() -> None:
    both = combine(SensorErrors(position=JointErrors(noise=7.0)), typical(2.0))
    assert both.position.noise == 7.0
    assert both.soles.force_noise == 2.0
    assert combine(SensorErrors(), SensorErrors()) == SensorErrors()


@pytest.mark.parametrize(
    "values",
    [
        {"position": {"noise": -1.0}},
        {"position": {"dropout": 1.0}},
        {"imu": {"delay_ms": 1001.0}},
        {"wrist": {"noise": 1.0}},
    ],
)
def test_impossible_errors_are_refused(values: dict[str, Any]) -> None:
    with pytest.raises(msgspec.ValidationError):
        msgspec.convert(values, SensorErrors)


def test_a_scale_beyond_its_limits_is_refused() -> None:
    with pytest.raises(ConfigError, match="noise scale -1"):
        typical(-1.0)
