"""What a scenario is: a scene with places in it, a first and a last prompt, and what they mean."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import msgspec
import numpy as np

from w2c.errors import ConfigError
from w2c.geometry import Matrix, Vector, apply
from w2c.messages import EndEffector, Task

Vector3 = tuple[float, float, float]
Side = Literal["left", "right", "behind", "front"]


@dataclass(frozen=True)
class Place:
    """Where on a thing, or beside it. The surface that is seen there is meant."""

    description: str
    """For people: `the middle of the book`"""
    thing: str
    """Name of the object in the scene"""
    share: Vector3 = (0.0, 0.0, 1.0)
    """Of its size, along its own axes, from the middle of its underside"""
    spread: Vector3 = (0.0, 0.0, 0.0)
    """How far each share may differ, drawn for each run"""
    beside: Vector3 = (0.0, 0.0, 0.0)
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
        return replace(self, share=(share[0], share[1], share[2]), spread=(0.0, 0.0, 0.0))

    def aim(self, world_from_object: Matrix, size: Vector3) -> Vector:
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


@dataclass(frozen=True)
class Scenario:
    """One of the paper's four experiments, in one layout."""

    name: str
    prompts: tuple[Prompt, ...]

    def phrases(self) -> dict[str, str]:
        """Return the words of all prompts that name a thing, and the object they mean."""
        return {
            words: thing
            for prompt in self.prompts
            for words, thing in prompt.meaning.things.items()
        }


class _Instruction(msgspec.Struct, frozen=True):
    """What the evaluation reads of an instruction in a scene file."""

    prompt: str
    end_effector: EndEffector
    task: Task
    things: dict[str, str]
    thing: str
    description: str = ""
    share: Vector3 = (0.0, 0.0, 1.0)
    beside: Vector3 = (0.0, 0.0, 0.0)
    on: tuple[str, ...] = ()
    touches: tuple[str, ...] = ()


class _SceneFile(msgspec.Struct, frozen=True):
    instructions: tuple[_Instruction, ...]


def read_scenario(name: str, scene_path: Path, spreads: Sequence[Vector3] = ()) -> Scenario:
    """Return the scenario that a scene file's instructions tell.

    Args:
        name: Of the scenario.
        scene_path: The file.
        spreads: How far the place of each prompt may differ, as `Place.spread`.

    Raises:
        ConfigError: the file has no instructions that can be played.
    """
    try:
        told = msgspec.json.decode(scene_path.read_bytes(), type=_SceneFile).instructions
    except (OSError, msgspec.DecodeError) as error:
        raise ConfigError(f"{scene_path} cannot be played: {error}") from error
    if not told:
        raise ConfigError(f"{scene_path} has no instructions: nothing is to be said there")
    missing = [(0.0, 0.0, 0.0)] * (len(told) - len(spreads))
    prompts = (_prompt(*pair) for pair in zip(told, (*spreads, *missing), strict=False))
    return Scenario(name, tuple(prompts))


def _prompt(told: _Instruction, spread: Vector3) -> Prompt:
    side = side_of(told.beside)
    return Prompt(
        told.prompt,
        Meaning(
            told.end_effector,
            told.task,
            "absolute" if side is None else "relative",
            dict(told.things),
            side,
        ),
        Place(told.description, told.thing, told.share, spread, told.beside, told.on),
        told.touches,
    )


def side_of(beside: Vector3) -> Side | None:
    """Return the side in the picture of who looks ahead; x of the world is ahead, y left."""
    x, y, _ = beside
    if max(abs(x), abs(y)) == 0.0:
        return None
    if abs(y) >= abs(x):
        return "left" if y > 0.0 else "right"
    return "behind" if x > 0.0 else "front"
