"""What an operator sees: a picture, a dot, a ring, and things with names; lengths inexactly."""

from dataclasses import dataclass
from math import hypot

import numpy as np

RING_PX = 18.0
"""Radius of the circle around the wanted place, as in the paper [px]"""
DOT_PX = 5.0
"""Radius of the circle around the shown point, as in the paper [px]"""
ERROR = 0.25
"""Of every length that is seen"""

Pixel = tuple[float, float]


@dataclass(frozen=True)
class Thing:
    """Something in the picture that has a name."""

    names: tuple[str, ...]
    """That fit nothing else in sight; those with a colour come last"""
    plain_names: int
    """So many of them are without a colour"""
    left: float
    top: float
    right: float
    bottom: float
    """Of what is visible of it [px]"""
    pixels_per_cm: float
    """How long a centimetre looks there"""
    furniture: bool = False

    @property
    def centre(self) -> Pixel:
        """The middle of it."""
        return self.at(0.5, 0.5)

    def at(self, across: float, down: float) -> Pixel:
        """Return the pixel at shares of its width and height, from left and top."""
        width, height = self.right - self.left, self.bottom - self.top
        return self.left + across * width, self.top + down * height


@dataclass(frozen=True)
class Look:
    """One look at the picture."""

    dot: Pixel | None
    """The point that the robot shows; None: none"""
    ring: Pixel
    """The wanted place"""
    things: tuple[Thing, ...]
    pixels_per_cm: float
    """At the ring. A person tells it from the size of known things, as inexactly as any length"""

    @property
    def inside(self) -> bool:
        """Whether the dot lies in the ring as a whole: everybody sees that."""
        return self.dot is not None and distance(self.dot, self.ring) <= RING_PX - DOT_PX


class Eye:
    """Estimates lengths, each with an error of its own."""

    def __init__(self, rng: np.random.Generator, error: float = ERROR) -> None:
        self._rng = rng
        self._error = error

    def offset(self, start: Pixel, end: Pixel) -> Pixel:
        """Return how far it seems from one place to another, across and down [px]."""
        return (end[0] - start[0]) * self._factor(), (end[1] - start[1]) * self._factor()

    def length(self, value: float) -> float:
        """Return how long something seems."""
        return value * self._factor()

    def _factor(self) -> float:
        return float(self._rng.uniform(1.0 - self._error, 1.0 + self._error))


def distance(one: Pixel, other: Pixel) -> float:
    """Return how far two places are apart [px]."""
    return hypot(one[0] - other[0], one[1] - other[1])
