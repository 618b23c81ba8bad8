"""What a scenario is: a scene with places in it, a first and a last prompt, and what they mean."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np

from w2c.errors import ConfigError
from w2c.geometry import Matrix, Vector, apply
from w2c.messages import EndEffector, Task

Side = Literal["left", "right", "behind", "front"]


@dataclass(frozen=True)
class Place:
    """Where on a thing, or beside it. The surface that is seen there is meant."""

    description: str
    """For people: `the middle of the book`"""
    thing: str
    """Name of the object in the scene"""
    share: tuple[float, float, float] = (0.0, 0.0, 1.0)
    """Of its size, along its own axes, from the middle of its underside"""
    spread: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """How far each share may differ, drawn for each run"""
    beside: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Further from there, along the axes of the world [m]"""
    on: tuple[str, ...] = ()
    """Objects whose surface may be seen there; none = the thing itself"""

    @property
    def surfaces(self) -> tuple[str, ...]:
        """Return the objects whose surface may be seen at the place."""
        return self.on or (self.thing,)

    def drawn(self, rng: np.random.Generator) -> "Place":
        """Return the place of one run."""
        share = tuple(
            middle + float(rng.uniform(-spread, spread)) if spread else middle
            for middle, spread in zip(self.share, self.spread, strict=True)
        )
        return Place(self.description, self.thing, (share[0], share[1], share[2]),
                     beside=self.beside, on=self.on)  # fmt: skip

    def aim(self, world_from_object: Matrix, size: tuple[float, float, float]) -> Vector:
        """Return the point (3,) in the world that the place is at or behind [m]."""
        in_object = np.multiply(self.share, size)
        return np.asarray(apply(world_from_object, in_object) + np.asarray(self.beside))


@dataclass(frozen=True)
class Meaning:
    """What a perfect listener makes of a prompt."""

    effector: EndEffector
    task: Task
    position: Literal["absolute", "relative"]
    things: dict[str, str]
    """Words that name a thing, in order of mention, and the object that they mean"""
    side: Side | None = None
    """Of the first thing, in the picture, where the place is relative to it"""


@dataclass(frozen=True)
class Prompt:
    """One of the paper's prompts, and the place that the operator has in mind."""

    text: str
    meaning: Meaning
    place: Place
    touches: tuple[str, ...] = ()
    """Further objects that this hand may touch there: what lies under a cloth"""

    def __post_init__(self) -> None:
        """Refuse words that are not in the text."""
        for words in self.meaning.things:
            if words.lower() not in self.text.lower():
                raise ConfigError(f"'{words}' is not in the prompt '{self.text}'")


Layout = Callable[[int, Path], str]
"""Draws the layout of a seed, writes its scene file, and says it for a log. Raises ConfigError."""


@dataclass(frozen=True)
class Scenario:
    """One of the paper's four experiments."""

    name: str
    title: str
    prompts: tuple[Prompt, ...]
    draw_layout: Layout = field(repr=False)

    def phrases(self) -> dict[str, str]:
        """Return the words of all prompts that name a thing, and the object they mean."""
        return {
            words: thing
            for prompt in self.prompts
            for words, thing in prompt.meaning.things.items()
        }
