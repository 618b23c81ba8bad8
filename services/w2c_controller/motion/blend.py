"""The way from the command in force to one's own."""

import numpy as np
import numpy.typing as npt

Vector = npt.NDArray[np.float64]


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
