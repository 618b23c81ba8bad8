"""Whether something that should move still does."""

import math

import numpy as np
import numpy.typing as npt

from w2c_controller.parameters import Motion

Vector = npt.NDArray[np.float64]


class Standstill:
    """True once a number has changed by less than `change` within a time."""

    def __init__(self, change: float, time: float, dt: float) -> None:
        self._change = change
        self._time = time
        self._dt = dt
        self.reset()

    def reset(self) -> None:
        """Start to watch anew."""
        self._anchor = float("nan")
        self._still = 0.0

    def step(self, value: float) -> bool:
        """Look at the number of this tick."""
        if abs(value - self._anchor) < self._change:
            self._still += self._dt
        else:
            self._anchor = value
            self._still = 0.0
        return self._still >= self._time


class StallDetector:
    """True once a position has moved less than `stall_distance` within `stall_time`."""

    def __init__(self, motion: Motion, dt: float) -> None:
        self._distance = motion.stall_distance
        self._time = motion.stall_time
        self._dt = dt
        self.reset()

    def reset(self) -> None:
        """Start to watch anew."""
        self._anchor: list[float] = []
        self._still = 0.0

    def step(self, position: Vector) -> bool:
        """Look at the position (3,) of this tick [m]."""
        point = position.tolist()
        if not self._anchor or math.dist(point, self._anchor) > self._distance:
            self._anchor = point
            self._still = 0.0
        else:
            self._still += self._dt
        return self._still >= self._time
