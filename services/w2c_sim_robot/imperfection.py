"""Sensors that err: noise, bias, delay, and readings that do not arrive."""

import numpy as np

from w2c.messages import Array
from w2c_sim_robot.sensing import Channels
from w2c_sim_robot.sensor_errors import ForceTorqueErrors, ImuErrors, JointErrors, SensorErrors


class Imperfection:
    """Turns what ideal sensors read at each tick into what these sensors read.

    A fixed number of random values is drawn at each tick, whatever errors there are: the same seed
    gives an encoder the same noise, with and without noise of other sensors.
    """

    def __init__(
        self,
        errors: SensorErrors,
        channels: Channels,
        generator: np.random.Generator,
        *,
        period_s: float,
    ) -> None:
        """Draw the biases.

        Args:
            errors: of each sensor.
            channels: of the vectors of readings.
            generator: seeded; nobody else may draw from it.
            period_s: of a tick [s].
        """
        self._generator = generator
        self._orientation = channels.orientation
        self._devices = _devices(errors, channels)
        self._dropouts = np.array([device.dropout for _, device in self._devices])
        self._delays = [round(device.delay_ms * 1e-3 / period_s) for _, device in self._devices]
        self._noise, bias = _deviations(errors, channels)
        self._turn_noise = errors.imu.orientation_noise
        self._bias = bias * generator.uniform(-1.0, 1.0, channels.width)
        self._turn_bias = errors.imu.orientation_bias * generator.uniform(-1.0, 1.0, 3)
        self._start = generator.bit_generator.state
        self._ring = np.zeros((max(self._delays) + 1, channels.width))
        """The samples of the last ticks."""
        self._last = np.zeros(channels.width)
        self._out = np.zeros(channels.width)
        self._count = 0

    def reset(self) -> None:
        """Begin anew: the same readings will get the same errors."""
        self._generator.bit_generator.state = self._start
        self._count = 0

    def read(self, ideal: Array) -> Array:
        """Return what is read at the next tick (width,): valid until the one after.

        Args:
            ideal: what ideal sensors would read (width,).
        """
        ring = self._ring
        sample = ideal + self._bias + self._noise * self._generator.standard_normal(len(ideal))
        turn = self._turn_bias + self._turn_noise * self._generator.standard_normal(3)
        sample[self._orientation] = _turned(ideal[self._orientation], turn)
        lost = self._generator.random(len(self._devices)) < self._dropouts
        if self._count == 0:
            ring[:] = sample  # nothing older than the start can be read
        elif lost.any():
            for (where, _), gone in zip(self._devices, lost, strict=True):
                if gone:
                    sample[where] = self._last[where]
        ring[self._count % len(ring)] = sample
        self._last = sample
        for (where, _), delay in zip(self._devices, self._delays, strict=True):
            self._out[where] = ring[(self._count - delay) % len(ring), where]
        self._count += 1
        return self._out


def _devices(
    errors: SensorErrors, channels: Channels
) -> list[tuple[slice, JointErrors | ForceTorqueErrors | ImuErrors]]:
    """Return what is read, delayed and lost together: where it is, and its errors."""
    wrenches = channels.wrenches.start
    return [
        (channels.position, errors.position),
        (channels.velocity, errors.velocity),
        (channels.torque, errors.torque),
        (slice(wrenches, wrenches + 6), errors.soles),
        (slice(wrenches + 6, wrenches + 12), errors.soles),
        (slice(wrenches + 12, wrenches + 18), errors.wrist),
        (slice(channels.orientation.start, channels.acceleration.stop), errors.imu),
    ]


def _deviations(errors: SensorErrors, channels: Channels) -> tuple[Array, Array]:
    """Return the standard deviation and the largest bias of each value (width,)."""
    noise, bias = np.zeros(channels.width), np.zeros(channels.width)
    joints = (channels.position, errors.position), (channels.velocity, errors.velocity)
    for where, joint in (*joints, (channels.torque, errors.torque)):
        noise[where], bias[where] = joint.noise, joint.bias
    for index, sensor in enumerate((errors.soles, errors.soles, errors.wrist)):
        force = channels.wrenches.start + 6 * index
        noise[force : force + 3], bias[force : force + 3] = sensor.force_noise, sensor.force_bias
        moment = force + 3
        noise[moment : moment + 3] = sensor.moment_noise
        bias[moment : moment + 3] = sensor.moment_bias
    imu = errors.imu
    noise[channels.angular_velocity] = imu.angular_velocity_noise
    bias[channels.angular_velocity] = imu.angular_velocity_bias
    noise[channels.acceleration] = imu.acceleration_noise
    bias[channels.acceleration] = imu.acceleration_bias
    return noise, bias


def _turned(orientation: Array, turn: Array) -> Array:
    """Return a quaternion xyzw after a turn about its own axes (3,) [rad]."""
    angle = float(np.linalg.norm(turn))
    if angle == 0.0:
        return orientation
    a, b, c = (np.sin(angle / 2.0) / angle * turn).tolist()
    d = float(np.cos(angle / 2.0))
    x, y, z, w = orientation.tolist()
    return np.array(
        [
            w * a + x * d + y * c - z * b,
            w * b - x * c + y * d + z * a,
            w * c + x * b - y * a + z * d,
            w * d - x * a - y * b - z * c,
        ]
    )
