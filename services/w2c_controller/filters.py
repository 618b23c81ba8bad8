"""What stands between a target and the QP: anti-windup, a low-pass, and a bang-bang planner."""

import math

import numpy as np
import numpy.typing as npt
import pinocchio as pin

from w2c_controller.parameters import Filters
from w2c_controller.program import clamp_norm

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]


def low_pass_gain(cutoff_hz: float, dt: float) -> float:
    """Return alpha = (1 - w dt/2) / (1 + w dt/2) of the low-pass x <- alpha x + (1 - alpha) u."""
    half = math.pi * cutoff_hz * dt
    return max((1.0 - half) / (1.0 + half), 0.0)


class LowPass:
    """First order, of any shape; starts at its first input."""

    def __init__(self, cutoff_hz: float, dt: float) -> None:
        self._alpha = low_pass_gain(cutoff_hz, dt)
        self._value: Vector | None = None

    def reset(self) -> None:
        """Forget: the next input is the output."""
        self._value = None

    def step(self, value: Vector) -> Vector:
        """Return the filtered value. NaN passes through and is not remembered."""
        if not np.isfinite(value).all():
            return np.asarray(value)
        if self._value is None:
            self._value = np.array(value, dtype=np.float64)
        else:
            self._value = self._alpha * self._value + (1.0 - self._alpha) * value
        return self._value


def bang_bang_speed(
    error: Vector, speed: Vector, top: float, acceleration: float, dt: float
) -> Vector:
    """Return the next speed, axis by axis, of the time-optimal way to remove an error.

    Full acceleration towards the largest speed from which full braking still stops at the target.
    The braking curve is that of discrete steps, so the last one does not overshoot.

    Args:
        error: (3,) target minus position.
        speed: (3,) now.
        top: Largest speed.
        acceleration: Largest acceleration.
        dt: Period [s].
    """
    half = 0.5 * acceleration * dt
    braking = np.sqrt(half * half + 2.0 * acceleration * np.abs(error)) - half
    wanted = np.sign(error) * np.minimum(np.minimum(braking, top), np.abs(error) / dt)
    change = acceleration * dt
    return np.asarray(speed + np.minimum(np.maximum(wanted - speed, -change), change))


class HandFilter:
    """Turns a target pose that may jump into one that the QP can follow."""

    def __init__(self, filters: Filters, dt: float, position: Vector, rotation: Matrix) -> None:
        self._filters = filters
        self._dt = dt
        self._alpha = low_pass_gain(filters.low_pass_hz, dt)
        self.reset(position, rotation)

    def reset(self, position: Vector, rotation: Matrix) -> None:
        """Start again, at rest, from a pose."""
        self.position = position.copy()
        self.rotation = rotation.copy()
        self._smooth_position = position.copy()
        self._smooth_rotation = rotation.copy()
        self._speed = np.zeros(3)
        self._turn = np.zeros(3)

    def step(self, target: Vector, turned: Matrix, hand: Vector, hand_turned: Matrix) -> None:
        """Move `position` and `rotation` by one tick.

        Args:
            target: (3,) where the hand shall be, in the world.
            turned: (3, 3) world_from_hand wanted.
            hand: (3,) where the desired posture has it: the command leads by a bounded distance.
            hand_turned: (3, 3) world_from_hand of the desired posture.
        """
        filters, dt, rest = self._filters, self._dt, 1.0 - self._alpha
        lead = clamp_norm(target - hand, filters.lead_position)
        self._smooth_position = self._smooth_position + rest * (hand + lead - self._smooth_position)
        turn = clamp_norm(np.asarray(pin.log3(turned @ hand_turned.T)), filters.lead_rotation)
        anchor = pin.exp3(turn) @ hand_turned
        step = rest * np.asarray(pin.log3(anchor @ self._smooth_rotation.T))
        self._smooth_rotation = pin.exp3(step) @ self._smooth_rotation
        self._speed = bang_bang_speed(
            self._smooth_position - self.position,
            self._speed,
            filters.speed,
            filters.acceleration,
            dt,
        )
        self.position = self.position + dt * self._speed
        error = np.asarray(pin.log3(self._smooth_rotation @ self.rotation.T))
        self._turn = bang_bang_speed(
            error, self._turn, filters.angular_speed, filters.angular_acceleration, dt
        )
        self.rotation = pin.exp3(dt * self._turn) @ self.rotation


class Blend:
    """From the command in force to one's own, smooth at both ends: s(u) = 3u^2 - 2u^3."""

    def __init__(self, start: Vector, duration: float, dt: float) -> None:
        """Begin at a command.

        Args:
            start: (n,) the command in force [rad].
            duration: Of the blend [s].
            dt: Period [s].
        """
        self._start = start.copy()
        self._step = dt / duration
        self._u = 0.0

    @property
    def done(self) -> bool:
        """Whether one's own command is all that is left."""
        return self._u >= 1.0

    def advance(self) -> float:
        """Move by one tick; returns the weight of one's own command, 0 to 1."""
        self._u = min(self._u + self._step, 1.0)
        return self._u * self._u * (3.0 - 2.0 * self._u)

    def mix(self, own: Vector) -> Vector:
        """Return the blended command (n,) [rad]."""
        if self.done:
            return own
        weight = self._u * self._u * (3.0 - 2.0 * self._u)
        return self._start + weight * (own - self._start)
