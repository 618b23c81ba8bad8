"""The way of a hand: a curve to a point above the target, then straight down along the normal.

Each leg is a cubic Bezier curve travelled with the minimum-jerk time law
s(u) = 10u^3 - 15u^4 + 6u^5: it starts and ends at rest.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Vector = npt.NDArray[np.float64]

_SAMPLES = 100
_SHORTEST = 0.2


@dataclass(frozen=True)
class Leg:
    """A cubic Bezier curve with a duration."""

    points: Vector
    """(4, 3) control points [m]"""
    duration: float
    """[s]"""

    def position(self, time: float) -> Vector:
        """Return the point (3,) at a time since the start of the leg; its ends hold outside."""
        u = min(max(time / self.duration, 0.0), 1.0)
        return np.asarray(_bezier(np.array(u)) @ self.points)


def _bezier(u: Vector) -> Vector:
    """Return the weights (..., 4) of the control points at a share u of the duration."""
    s = u * u * u * (10.0 - 15.0 * u + 6.0 * u * u)
    rest = 1.0 - s
    return np.stack([rest**3, 3 * s * rest**2, 3 * s * s * rest, s**3], axis=-1)


def make_leg(points: Vector, speed: float) -> Leg:
    """Return the leg through control points (4, 3) with this top speed [m/s]."""
    curve = _bezier(np.linspace(0.0, 1.0, _SAMPLES + 1)) @ points
    fastest = float(np.linalg.norm(np.diff(curve, axis=0), axis=1).max()) * _SAMPLES
    return Leg(points, max(fastest / speed, _SHORTEST))


def straight(start: Vector, end: Vector, speed: float) -> Leg:
    """Return a straight leg."""
    steps = np.linspace(0.0, 1.0, 4)[:, None]
    return make_leg(start + steps * (end - start), speed)


def curved(start: Vector, end: Vector, normal: Vector, speed: float) -> Leg:
    """Return a leg that leaves upwards and arrives against the normal of the surface.

    Args:
        start: (3,) [m]
        end: (3,), above the surface [m]
        normal: (3,) unit, of the surface at the end.
        speed: Top speed [m/s].
    """
    swing = 0.3 * float(np.linalg.norm(end - start))
    lift = start + min(swing, 0.1) * np.array([0.0, 0.0, 1.0])
    return make_leg(np.stack([start, lift, end + min(swing, 0.1) * normal, end]), speed)


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
