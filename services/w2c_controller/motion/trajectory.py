"""The way of an end effector as legs, each a cubic Bezier curve with a time law.

With u = t / T and s(u) the minimum-jerk law for an initial rate r,

    p(t) = B(s(u)) + d q(t / T_d) T_d,    s' = (1 - u)^2 (r + 2 r u + (30 - 15 r) u^2),
                                          q(x) = x (1 - x)^3,

a leg ends at rest and begins with any velocity: r carries the part of it along the curve, and the
drift d the rest, which is braked within T_d. So a goal that changes while the hand moves is
followed without a jump of velocity.
"""

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled

Vector = npt.NDArray[np.float64]

BRAKING_TIME = 0.8
"""T_d, at most [s]: a drift of 0.18 m/s is braked with 1.4 m/s^2, and within 15 mm."""
HIGHEST_RATE = 2.0
"""Of r: up to 2.5 the hand never goes back on the curve."""

_SAMPLES = 100
_SHORTEST = 0.2


@compiled
def bezier_point(points: Vector, s: float, out: Vector) -> None:
    """Write the point (3,) of a cubic Bezier curve with control points (4, 3) at s in [0, 1]."""
    rest = 1.0 - s
    a, b = rest * rest * rest, 3.0 * s * rest * rest
    c, d = 3.0 * s * s * rest, s * s * s
    for i in range(3):
        out[i] = a * points[0, i] + b * points[1, i] + c * points[2, i] + d * points[3, i]


@compiled
def progress(u: float, rate: float) -> float:
    """Return s(u), the share of the curve after a share u of the time."""
    cubic = 10.0 - 6.0 * rate + u * (8.0 * rate - 15.0 + u * (6.0 - 3.0 * rate))
    return u * (rate + u * u * cubic)


@compiled
def leg_point(
    points: Vector, duration: float, rate: float, drift: Vector, time: float, out: Vector
) -> None:
    """Write the point (3,) of a leg at a time since its start; its ends hold outside."""
    u = min(max(time / duration, 0.0), 1.0)
    bezier_point(points, min(max(progress(u, rate), 0.0), 1.0), out)
    braking = min(BRAKING_TIME, duration)
    x = min(max(time / braking, 0.0), 1.0)
    share = braking * x * (1.0 - x) * (1.0 - x) * (1.0 - x)
    for i in range(3):
        out[i] += share * drift[i]


@compiled
def leg_velocity(
    points: Vector, duration: float, rate: float, drift: Vector, time: float, out: Vector
) -> None:
    """Write the velocity (3,) of a leg at a time since its start [m/s]; zero outside."""
    out[:] = 0.0
    if 0.0 <= time <= duration:
        u = time / duration
        s, rest = progress(u, rate), 1.0 - progress(u, rate)
        slow = (1.0 - u) * (1.0 - u) * (rate + 2.0 * rate * u + (30.0 - 15.0 * rate) * u * u)
        a, b, c = 3.0 * rest * rest, 6.0 * s * rest, 3.0 * s * s
        for i in range(3):
            out[i] = (slow / duration) * (
                a * (points[1, i] - points[0, i])
                + b * (points[2, i] - points[1, i])
                + c * (points[3, i] - points[2, i])
            )
    braking = min(BRAKING_TIME, duration)
    if 0.0 <= time <= braking:
        x = time / braking
        for i in range(3):
            out[i] += (1.0 - x) * (1.0 - x) * (1.0 - 4.0 * x) * drift[i]


@compiled
def _fastest(points: Vector, rate: float, before: Vector, after: Vector) -> float:
    """Return the top speed on the curve for a duration of 1 s [m/s]; the last two are scratch."""
    fastest = 0.0
    bezier_point(points, 0.0, before)
    for n in range(1, _SAMPLES + 1):
        bezier_point(points, progress(n / _SAMPLES, rate), after)
        squared = 0.0
        for i in range(3):
            squared += (after[i] - before[i]) * (after[i] - before[i])
            before[i] = after[i]
        fastest = max(fastest, squared)
    return float(fastest**0.5) * _SAMPLES


@dataclass(frozen=True)
class Bow:
    """How far the curve is drawn away from the direct one."""

    up: float = 0.0
    """[m]"""
    side: float = 0.0
    """To the left of the way [m]"""

    @property
    def detour(self) -> float:
        """Return what it costs."""
        return self.up + 1.5 * abs(self.side)


@dataclass(frozen=True)
class Leg:
    """A cubic Bezier curve with a duration."""

    points: Vector
    """(4, 3) control points [m]"""
    duration: float
    """[s]"""
    rate: float = 0.0
    """r: initial speed along the curve, in curve parameters a duration"""
    drift: Vector = field(default_factory=lambda: np.zeros(3))
    """d (3,): initial velocity beside the curve [m/s]"""

    def position(self, time: float) -> Vector:
        """Return the point (3,) at a time since the start of the leg; its ends hold outside."""
        point = np.empty(3)
        leg_point(self.points, self.duration, self.rate, self.drift, time, point)
        return point

    def velocity(self, time: float) -> Vector:
        """Return the velocity (3,) at a time since the start of the leg [m/s]; zero outside."""
        velocity = np.empty(3)
        leg_velocity(self.points, self.duration, self.rate, self.drift, time, velocity)
        return velocity


def make_leg(points: Vector, speed: float, velocity: Vector | None = None) -> Leg:
    """Return the leg through control points (4, 3).

    Args:
        points: (4, 3) [m].
        speed: Top speed along the curve [m/s].
        velocity: (3,) at the start [m/s]; None: at rest.
    """
    scratch = np.empty((2, 3))
    if velocity is None or not velocity.any():
        return Leg(points, max(_fastest(points, 0.0, scratch[0], scratch[1]) / speed, _SHORTEST))
    duration = max(_fastest(points, 0.0, scratch[0], scratch[1]) / speed, BRAKING_TIME)
    tangent = 3.0 * (points[1] - points[0])
    squared = float(tangent @ tangent)
    along = max(float(velocity @ tangent), 0.0) / squared if squared > 1e-12 else 0.0
    rate = min(along * duration, HIGHEST_RATE)
    duration = max(_fastest(points, rate, scratch[0], scratch[1]) / speed, BRAKING_TIME)
    rate = min(along * duration, HIGHEST_RATE)
    return Leg(points, duration, rate, np.asarray(velocity - rate / duration * tangent))


def straight(start: Vector, end: Vector, speed: float) -> Leg:
    """Return a straight leg from rest to rest."""
    steps = np.linspace(0.0, 1.0, 4)[:, None]
    return make_leg(start + steps * (end - start), speed)


class Path:
    """Legs one after another, with a clock that the follower advances: it may wait for the hand."""

    def __init__(self, legs: tuple[Leg, ...]) -> None:
        self.legs = legs
        self._leg = 0
        self._time = 0.0

    @property
    def leg(self) -> int:
        """Index of the leg being travelled; the last one also at its end."""
        return self._leg

    @property
    def finished(self) -> bool:
        """Whether the end of the last leg was reached."""
        return self._leg == len(self.legs) - 1 and self._time >= self.legs[-1].duration

    @property
    def end(self) -> Vector:
        """Where the path ends (3,)."""
        return np.asarray(self.legs[-1].points[3])

    def position(self) -> Vector:
        """Return the point (3,) now."""
        return self.legs[self._leg].position(self._time)

    def velocity(self) -> Vector:
        """Return the velocity (3,) now, of a follower that does not wait [m/s]."""
        return self.legs[self._leg].velocity(self._time)

    def advance(self, dt: float) -> None:
        """Move the clock; a leg that is done gives way to the next."""
        self._time += dt
        last = self._leg == len(self.legs) - 1
        if not last and self._time >= self.legs[self._leg].duration:
            self.next_leg()

    def next_leg(self) -> None:
        """Go to the start of the next leg, wherever this one was."""
        if self._leg < len(self.legs) - 1:
            self._leg += 1
            self._time = 0.0
