"""Colours by the name a person gives them."""

from dataclasses import dataclass

import numpy as np

from w2c.geometry import Vector

Colour = tuple[float, float, float]

COLOURS: dict[str, Colour] = {
    "red": (0.74, 0.09, 0.10),
    "orange": (0.93, 0.45, 0.07),
    "yellow": (0.93, 0.78, 0.12),
    "green": (0.13, 0.50, 0.20),
    "blue": (0.10, 0.26, 0.66),
    "purple": (0.43, 0.16, 0.56),
    "pink": (0.93, 0.50, 0.64),
    "brown": (0.42, 0.25, 0.13),
    "black": (0.09, 0.09, 0.10),
    "grey": (0.48, 0.49, 0.51),
    "white": (0.93, 0.93, 0.91),
    "turquoise": (0.10, 0.62, 0.64),
}
"""sRGB from 0 to 1; the middle of what people call by the name."""


@dataclass(frozen=True)
class Paints:
    """The colours an object is painted in: its own, and one for what is printed on it."""

    main: Colour
    accent: Colour


def shade(colour: Colour, rng: np.random.Generator, spread: float = 0.05) -> Colour:
    """Return a colour nearby that still has the same name: lighter or darker, never another hue."""
    base: Vector = np.asarray(colour)
    brightness = 1.0 + rng.uniform(-2.0, 2.0) * spread
    # Grey stays grey: the eye sees the slightest hue in it.
    tint = rng.uniform(-spread, spread, 3) * min(0.5, float(np.ptp(base)))
    red, green, blue = np.clip(base * brightness + tint, 0.02, 0.98)
    return float(red), float(green), float(blue)


def contrasting(colour: Colour) -> Colour:
    """Return the colour of print that can be read on this one."""
    luminance = 0.2126 * colour[0] + 0.7152 * colour[1] + 0.0722 * colour[2]
    return (0.96, 0.93, 0.82) if luminance < 0.45 else (0.12, 0.12, 0.16)
