"""What stands in front of the robot, as data: one JSON file for physics and camera."""

from pathlib import Path
from typing import Annotated, Literal

import msgspec
import numpy as np

from w2c.errors import ConfigError
from w2c.geometry import Matrix, Vector, apply, rotation_from_quaternion, transform
from w2c.messages import EndEffector

Vector3 = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
Identifier = Annotated[str, msgspec.Meta(pattern=r"^[a-z][a-z0-9_]{0,63}$")]
Support = Literal["carries", "slides", "fragile", "forbidden"]

UPRIGHT: Quaternion = (0.0, 0.0, 0.0, 1.0)


class SceneObject(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One thing. Its frame: origin in the middle of its underside, x and y as its size, z up."""

    name: Identifier
    """Unique in the scene; the name of its body in the simulator"""
    kind: Identifier
    """What it is: one of `objects.catalogue.KINDS`"""
    names: Annotated[tuple[str, ...], msgspec.Meta(min_length=1)]
    """Words a person may use for it, the usual one first"""
    colour: str
    """The colour a person would name: one of `objects.palette.COLOURS`"""
    material: str = ""
    """wood, paper, ceramic ...; empty where nobody would say it"""
    size: Vector3
    """Extents along its own axes [m]"""
    position: Vector3
    """In the world [m]"""
    orientation: Quaternion = UPRIGHT
    """xyzw, world_from_object"""
    mass: Annotated[float, msgspec.Meta(gt=0.0, le=500.0)]
    """[kg]"""
    movable: bool
    """False: fixed to the world, a hand may lean on it with any force"""
    support: Support
    """carries: a hand may lean on it. slides: it moves or tips when pushed. fragile: it breaks.
    forbidden: no hand may go there, it burns, pricks, or must not be touched."""
    variant: Annotated[int, msgspec.Meta(ge=0)] = 0
    """Seed of its print, grain and pattern"""

    @property
    def world_from_object(self) -> Matrix:
        """Return the (4, 4) pose."""
        return transform(rotation_from_quaternion(self.orientation), self.position)

    @property
    def top_in_world(self) -> Vector3:
        """Return the middle of the upper side of an upright object [m]."""
        x, y, z = self.position
        return x, y, z + self.size[2]

    def phrases(self) -> tuple[str, ...]:
        """Return the phrases that fit: names alone, with the colour, one with the material."""
        with_colour = tuple(f"{self.colour} {name}" for name in self.names)
        with_material = (f"{self.material} {self.names[0]}",) if self.material else ()
        return (*self.names, *with_colour, *with_material)


class Instruction(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a person says in this scene, and the place they mean.

    The place is on the surface that is seen at the point `share` of the thing, moved by `beside`.
    """

    prompt: str
    end_effector: EndEffector
    task: Literal["contact", "reach", "lift"]
    """contact and reach as in a goal of the controller; lift: take that foot off the floor"""
    things: dict[str, Identifier] = {}
    """Words of the prompt that name a thing, in order of mention, and the object that they mean"""
    thing: str = ""
    """The object that the place belongs to; empty = none is meant"""
    description: str = ""
    """Of the place, for people: `the middle of the book`"""
    share: Vector3 = (0.0, 0.0, 1.0)
    """Of the thing's size, along its own axes, from the middle of its underside"""
    beside: Vector3 = (0.0, 0.0, 0.0)
    """Further from there, along the axes of the world [m]"""
    normal: Vector3 = (0.0, 0.0, 1.0)
    """Of the surface there, in the world"""
    on: tuple[Identifier, ...] = ()
    """Objects whose surface may be seen there; none = the thing itself"""
    touches: tuple[Identifier, ...] = ()
    """Further objects that this hand may touch there: what lies under a cloth"""
    corrections: tuple[str, ...] = ()
    """What the paper's operator said before the point was right"""


class Light(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A lamp of parallel rays, far away."""

    position: Vector3
    """Where it hangs, in the world [m]; only matters to its shadows"""
    direction: Vector3
    """Of its rays, in the world"""
    brightness: Annotated[float, msgspec.Meta(ge=0.0, le=2.0)] = 0.6
    warmth: Annotated[float, msgspec.Meta(ge=-1.0, le=1.0)] = 0.0
    """-1 bluish, 0 white, 1 like a candle"""
    shadow: bool = True


class Surroundings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The room."""

    floor: Literal["tiles", "wood", "concrete", "carpet"] = "tiles"
    floor_colour: Vector3 = (0.62, 0.63, 0.66)
    """Red, green, blue from 0 to 1"""
    wall_colour: Vector3 = (0.82, 0.84, 0.86)
    ambient: Annotated[float, msgspec.Meta(ge=0.0, le=1.0)] = 0.35
    """Light from everywhere"""
    variant: Annotated[int, msgspec.Meta(ge=0)] = 0


class Scene(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Everything but the robot."""

    name: Identifier
    seed: Annotated[int, msgspec.Meta(ge=0)] = 0
    objects: tuple[SceneObject, ...]
    lights: tuple[Light, ...]
    surroundings: Surroundings = Surroundings()
    instructions: tuple[Instruction, ...] = ()
    """In the order in which they are said; empty where a scene is not for one story"""

    def place(self, instruction: Instruction) -> Vector:
        """Return the point (3,) in the world that an instruction means [m]. Raises ConfigError."""
        item = self.object(instruction.thing)
        point = apply(item.world_from_object, np.multiply(instruction.share, item.size))
        return np.asarray(point + np.asarray(instruction.beside))

    def object(self, name: str) -> SceneObject:
        """Return the object of this name. Raises ConfigError."""
        for candidate in self.objects:
            if candidate.name == name:
                return candidate
        known = ", ".join(candidate.name for candidate in self.objects) or "none"
        raise ConfigError(f"no object '{name}' in scene '{self.name}'; it has: {known}")


def check(scene: Scene) -> None:
    """Raise ConfigError for what types cannot say: unknown kinds, odd sizes, overlap ..."""
    from w2c_sim_robot.scenes.objects.catalogue import KINDS
    from w2c_sim_robot.scenes.objects.palette import COLOURS

    seen: set[str] = set()
    for item in scene.objects:
        where = f"scene '{scene.name}', object '{item.name}'"
        if item.name in seen:
            raise ConfigError(f"{where}: the name is used twice; names are unique in a scene")
        seen.add(item.name)
        if item.kind not in KINDS:
            raise ConfigError(f"{where}: kind '{item.kind}'; known: {', '.join(sorted(KINDS))}")
        if item.colour not in COLOURS:
            raise ConfigError(
                f"{where}: colour '{item.colour}'; known: {', '.join(sorted(COLOURS))}"
            )
        if not all(0.0005 <= extent <= 20.0 for extent in item.size):
            raise ConfigError(f"{where}: size {item.size}, expected 0.0005 to 20 m along each axis")
        if not np.isfinite(item.position).all():
            raise ConfigError(f"{where}: position {item.position} is not finite")
        length = float(np.linalg.norm(item.orientation))
        if not abs(length - 1.0) < 1e-3:
            raise ConfigError(
                f"{where}: orientation of length {length:g}, expected a unit quaternion xyzw"
            )
    for instruction in scene.instructions:
        named = (instruction.thing, *instruction.things.values(), *instruction.on)
        for name in (*named, *instruction.touches):
            if name and name not in seen:
                raise ConfigError(
                    f"scene '{scene.name}', instruction '{instruction.prompt}': "
                    f"no object '{name}'; it has: {', '.join(sorted(seen))}"
                )
    _check_overlap(scene)
    for number, light in enumerate(scene.lights):
        if not float(np.linalg.norm(light.direction)) > 1e-6:
            raise ConfigError(f"scene '{scene.name}', light {number}: its direction is zero")


def _check_overlap(scene: Scene) -> None:
    from w2c_sim_robot.scenes.overlap import deepest_overlap

    found = deepest_overlap(scene.objects)
    if found is not None:
        first, second, depth = found
        raise ConfigError(
            f"scene '{scene.name}': '{first}' and '{second}' overlap by {1e3 * depth:.0f} mm; "
            "at most 2 mm may; move one of them or make it smaller"
        )


def load(path: Path) -> Scene:
    """Read and check a scene file. Raises ConfigError that names the file and the field."""
    try:
        scene = msgspec.json.decode(path.read_bytes(), type=Scene)
    except FileNotFoundError as error:
        raise ConfigError(
            f"no scene file at {path}; `w2c scenes make --out FILE` writes one"
        ) from error
    except OSError as error:
        raise ConfigError(f"scene file {path} cannot be read: {error}") from error
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise ConfigError(f"scene file {path}: {error}") from error
    check(scene)
    return scene


def save(scene: Scene, path: Path) -> None:
    """Check a scene and write it, readable by people. Raises ConfigError."""
    check(scene)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(msgspec.json.format(msgspec.json.encode(scene), indent=2) + b"\n")
    except OSError as error:
        raise ConfigError(f"scene file {path} cannot be written: {error}") from error
