"""Whether a surface is fit to carry a hand, by its shape alone: a reason for each verdict.

Material is not looked at: a pane of glass is as flat as a table.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from w2c.errors import ConfigError
from w2c.geometry import Vector, unit

Check = Literal["known", "flat", "large", "edge", "slope"]
DOWN: Vector = np.array([0.0, 0.0, -1.0])


@dataclass(frozen=True)
class Demands:
    """What a surface must be."""

    radius: float = 0.03
    """Of what touches it [m]"""
    roughness: float = 0.004
    """Root mean square distance from a plane, at most [m]"""
    margin: float = 0.02
    """Beyond what touches, to where the surface ends [m]"""
    friction: float = 0.6
    """Coefficient between hand and surface, as the controller assumes it"""
    error: float = 0.02
    """Of the point, at most [m]: the controller feels for a surface over about so much"""

    def __post_init__(self) -> None:
        """Raise ConfigError for demands that are none."""
        values = (self.radius, self.roughness, self.margin, self.friction, self.error)
        if not (np.isfinite(values).all() and min(values) >= 0.0 and self.radius > 0.0):
            raise ConfigError(f"{self}: expected finite numbers from 0 on, and a radius above 0")

    @property
    def steepest(self) -> float:
        """Return the slope that friction still holds [rad]."""
        return float(np.arctan(self.friction))


@dataclass(frozen=True)
class Shape:
    """What was measured of a surface around a point."""

    normal: Vector
    """(3,) out of the surface, in the world"""
    error_bound: float
    """[m]"""
    flatness: float
    """Root mean square distance to its plane, without noise [m]"""
    extent: float
    """Radius that is seen to be flat all around [m]"""
    edge_distance: float
    """To where the surface is seen to end [m]"""


@dataclass(frozen=True)
class Verdict:
    """One check."""

    check: Check
    fit: bool
    reason: str
    """For the operator, whether it is fit or not"""
    value: float
    limit: float
    """What was measured, and what it is held against [m], or [rad] for the slope"""


def judge(shape: Shape, demands: Demands, load: Vector = DOWN) -> tuple[Verdict, ...]:
    """Return a verdict for each check, in the order that an operator would ask.

    Args:
        shape: of the surface.
        demands: on it.
        load: (3,) direction in which the hand pushes, in the world: down for weight, into a wall
            for a push.

    Raises:
        GeometryError: a load, or a normal, without direction.
    """
    return (
        _known(shape, demands),
        _flat(shape, demands),
        _large(shape, demands),
        _edge(shape, demands),
        _slope(shape, demands, load),
    )


def is_fit(verdicts: tuple[Verdict, ...]) -> bool:
    """Tell whether all checks passed."""
    return all(verdict.fit for verdict in verdicts)


def _known(shape: Shape, demands: Demands) -> Verdict:
    fit = shape.error_bound <= demands.error
    words = "known" if fit else "not known well enough: only"
    text = f"its place is {words} to {_mm(shape.error_bound)}, limit {_mm(demands.error)}"
    return Verdict("known", fit, text, shape.error_bound, demands.error)


def _flat(shape: Shape, demands: Demands) -> Verdict:
    fit = shape.flatness <= demands.roughness
    word = "flat" if fit else "not flat"
    text = f"{word}: uneven by {_mm(shape.flatness)}, limit {_mm(demands.roughness)}"
    return Verdict("flat", fit, text, shape.flatness, demands.roughness)


def _large(shape: Shape, demands: Demands) -> Verdict:
    fit = shape.extent >= demands.radius
    word = "large enough" if fit else "too small, or something stands there"
    text = f"{word}: free for {_cm(shape.extent)} around, the hand needs {_cm(demands.radius)}"
    return Verdict("large", fit, text, shape.extent, demands.radius)


def _edge(shape: Shape, demands: Demands) -> Verdict:
    needed = demands.radius + demands.margin
    fit = shape.edge_distance >= needed
    word = "clear of edges" if fit else "near an edge"
    text = f"{word}: it ends {_cm(shape.edge_distance)} away or more, limit {_cm(needed)}"
    if not fit:
        text = f"{word}: it ends {_cm(shape.edge_distance)} away, limit {_cm(needed)}"
    return Verdict("edge", fit, text, shape.edge_distance, needed)


def _slope(shape: Shape, demands: Demands, load: Vector) -> Verdict:
    angle = float(np.arccos(np.clip(-unit(shape.normal) @ unit(load), -1.0, 1.0)))
    fit = angle <= demands.steepest
    degrees, limit = np.degrees(angle), np.degrees(demands.steepest)
    word = "level enough" if fit else "too steep"
    text = (
        f"{word}: {degrees:.0f} degrees from square to the load, friction {demands.friction:g} "
        f"holds up to {limit:.0f}"
    )
    if angle > np.pi / 2.0:
        text = f"faces away from the load, by {degrees:.0f} degrees: nothing to push against"
    return Verdict("slope", fit, text, angle, demands.steepest)


def _mm(length: float) -> str:
    return f"{1000.0 * length:.1f} mm"


def _cm(length: float) -> str:
    return f"{100.0 * length:.1f} cm"
