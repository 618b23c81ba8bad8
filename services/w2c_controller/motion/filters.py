"""Filters of one number: a low-pass, and a planner of the fastest way to a target."""

import math

from w2c_controller.compiled import compiled


def low_pass_gain(cutoff_hz: float, dt: float) -> float:
    """Return alpha = (1 - w dt/2) / (1 + w dt/2) of the low-pass x <- alpha x + (1 - alpha) u."""
    half = math.pi * cutoff_hz * dt
    return max((1.0 - half) / (1.0 + half), 0.0)


@compiled
def bang_bang_speed(
    error: float, speed: float, top: float, acceleration: float, dt: float
) -> float:
    """Return the next speed, on one axis, of the time-optimal way to remove an error.

    Full acceleration towards the largest speed from which full braking still stops at the target.
    The braking curve is that of discrete steps, so the last one does not overshoot.

    Args:
        error: Target minus position.
        speed: Now.
        top: Largest speed.
        acceleration: Largest acceleration.
        dt: Period [s].
    """
    distance = abs(error)
    half = 0.5 * acceleration * dt
    braking = math.sqrt(half * half + 2.0 * acceleration * distance) - half
    wanted = min(braking, top, distance / dt)
    if error < 0.0:
        wanted = -wanted
    change = acceleration * dt
    return speed + min(max(wanted - speed, -change), change)
