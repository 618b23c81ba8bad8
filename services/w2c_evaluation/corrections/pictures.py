"""Pictures of the simulator with their truth, and the places that operators shall point at.

The pictures are made by `w2c scenes render` and read from its files.
"""

import subprocess
import sys
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import cv2
import msgspec
import numpy as np
import numpy.typing as npt

from w2c.errors import ConfigError, ProcessError
from w2c_evaluation.corrections.eye import RING_PX, Pixel, Thing

WIDTH, HEIGHT = 1280, 720
FIRST_JUDGING_SEED = 900_000
"""Scenes from this seed on are never trained on"""
DEPTH_UNIT_M = 0.00025
LEAST_SEEN_PX = 500
"""Of a thing that somebody names [pixels]"""
LEAST_ROOM_PX = int(3 * RING_PX)
"""Between a ring and the border of the picture"""
ON_THING = 0.5
"""How many rings are on a thing; the others are on what things stand on"""
ROBOT, NOTHING = 255, 0


class TrueThing(msgspec.Struct, frozen=True):
    """What is used of an object of a truth file (docs/reference/scenes.md)."""

    id: int
    name: str
    colour: str
    names: list[str]
    phrases: list[str]
    box: tuple[int, int, int, int] | None
    visible_pixels: int
    movable: bool


class Truth(msgspec.Struct, frozen=True):
    """What is used of a truth file."""

    image: str
    identity: str
    width: int
    height: int
    intrinsics: tuple[float, float, float, float]
    world_from_camera: list[list[float]]
    objects: list[TrueThing]


@dataclass(frozen=True)
class Picture:
    """One picture and the truth about it."""

    seed: int
    directory: Path
    truth: Truth

    @property
    def name(self) -> str:
        """As in the names of its files."""
        return f"{self.seed:07d}"

    @cached_property
    def jpeg(self) -> bytes:
        """The colours."""
        return (self.directory / self.truth.image).read_bytes()

    @cached_property
    def identity(self) -> npt.NDArray[np.uint8]:
        """(h, w): the id of the object at each pixel, 0 = none, 255 = the robot."""
        return _read(self.directory / self.truth.identity).astype(np.uint8)

    @cached_property
    def depth(self) -> npt.NDArray[np.float32]:
        """(h, w) z-depth [m], 0 = unknown."""
        units = _read(self.directory / f"{self.name}_depth.png").astype(np.float32)
        return units * np.float32(DEPTH_UNIT_M)

    @property
    def visible(self) -> list[TrueThing]:
        """What is large enough in sight to be named."""
        return [
            one
            for one in self.truth.objects
            if one.box is not None and one.visible_pixels >= LEAST_SEEN_PX
        ]

    @cached_property
    def things(self) -> tuple[Thing, ...]:
        """What a person could name, by names that fit nothing else in sight."""
        visible = self.visible
        found = [
            _thing(one, [other for other in visible if other is not one], self._scale_of(one))
            for one in visible
        ]
        return tuple(thing for thing in found if thing is not None)

    def pixels_per_cm(self, pixel: Pixel) -> float:
        """Return how long a centimetre looks at a place [px]; 10 where its depth is not known."""
        z = float(self.depth[int(pixel[1]), int(pixel[0])])
        return 0.01 * self.truth.intrinsics[0] / z if z > 0.0 else 10.0

    def _scale_of(self, one: TrueThing) -> float:
        """Return how long a centimetre looks on a thing [px]."""
        rows, columns = np.nonzero(self.identity == one.id)
        middle = len(rows) // 2
        return self.pixels_per_cm((float(columns[middle]), float(rows[middle])))

    def draw_ring(self, rng: np.random.Generator) -> Pixel | None:
        """Return a place on a thing or on what things stand on; None: there is none."""
        inner = np.zeros(self.identity.shape, bool)
        inner[LEAST_ROOM_PX:-LEAST_ROOM_PX, LEAST_ROOM_PX:-LEAST_ROOM_PX] = True
        inner &= self.depth > 0.0
        things = [one for one in self.visible if one.movable]
        furniture = [one for one in self.visible if not one.movable]
        groups = (things, furniture) if rng.random() < ON_THING else (furniture, things)
        for group in groups:
            for index in rng.permutation(len(group)):
                rows, columns = np.nonzero((self.identity == group[index].id) & inner)
                if len(rows):
                    at = int(rng.integers(len(rows)))
                    return float(columns[at]) + 0.5, float(rows[at]) + 0.5
        return None


def render(directory: Path, first: int, count: int) -> None:
    """Make the pictures that are not there yet. Raises ProcessError."""
    command = [sys.executable, "-m", "w2c.cli", "scenes", "render", "--out", str(directory)]
    command += ["--seed", str(first), "--count", str(count), "--picture", "jpg", "--resume"]
    command += ["--width", str(WIDTH), "--height", str(HEIGHT)]
    status = subprocess.run(command, check=False).returncode
    if status != 0:
        raise ProcessError(f"`{' '.join(command)}` ended with {status}; its errors are above")


def read_picture(directory: Path, seed: int) -> Picture:
    """Return a picture. Raises ConfigError where it is missing or its truth is none."""
    path = directory / f"{seed:07d}.json"
    try:
        truth = msgspec.json.decode(path.read_bytes(), type=Truth)
    except (OSError, msgspec.DecodeError) as error:
        raise ConfigError(
            f"{path} is no truth about a picture: {error}; remove its directory and run again"
        ) from error
    return Picture(seed, directory, truth)


def _thing(one: TrueThing, others: list[TrueThing], scale: float) -> Thing | None:
    """Return what a person sees of an object; None: nothing that others are not called, too."""
    taken = {name for other in others for name in _names(other)}
    plain = [name for name in one.names if name not in taken]
    coloured = [name for name in _coloured(one) if name not in taken]
    if one.box is None or not plain + coloured:
        return None
    left, top, right, bottom = one.box
    return Thing(
        tuple(plain + coloured),
        len(plain),
        float(left),
        float(top),
        float(right),
        float(bottom),
        pixels_per_cm=scale,
        furniture=not one.movable,
    )


def _names(one: TrueThing) -> list[str]:
    return [*one.names, *_coloured(one)]


def _coloured(one: TrueThing) -> list[str]:
    return [f"{one.colour} {name}" for name in one.names]


def _read(path: Path) -> npt.NDArray[np.uint16]:
    image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    if image is None:
        raise ConfigError(f"{path} cannot be read; remove its directory and run again")
    return np.asarray(image, np.uint16)
