"""Pictures of random scenes with the truth behind every pixel, in memory: for the benchmark.

The same scenes, postures and light as `w2c scenes render`, and the same truth. A picture may be
told to look as if it was taken outdoors: sky instead of walls, grass, sand or paving for a floor,
and one strong sun. Outdoors is a look only; the things and their places stay.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

from w2c.errors import ConfigError
from w2c_sim_robot.camera.gl import choose_backend
from w2c_sim_robot.scenes.assets import SCENES_PER_STOCK
from w2c_sim_robot.scenes.objects.catalogue import KINDS
from w2c_sim_robot.scenes.objects.palette import Colour
from w2c_sim_robot.scenes.pool import Pool
from w2c_sim_robot.scenes.random_scene import random_scene
from w2c_sim_robot.scenes.render import SHADOW_SHARE, truth
from w2c_sim_robot.scenes.scene import Light, Scene, Surroundings

FIRST_JUDGING_SEED = 900_000
GRASS, SAND, EARTH = (0.36, 0.55, 0.22), (0.85, 0.74, 0.52), (0.52, 0.40, 0.29)
PAVING, DECKING = (0.62, 0.60, 0.57), (0.55, 0.42, 0.31)
GROUNDS = {
    "carpet": (GRASS, GRASS, SAND),
    "concrete": (GRASS, SAND, EARTH, PAVING),
    "tiles": (PAVING, SAND),
    "wood": (DECKING,),
}
"""What is underfoot outdoors, by the pattern of the floor: the colour that multiplies it"""


@dataclass(frozen=True)
class TruePicture:
    """A picture, and what each of its pixels shows."""

    rgb: npt.NDArray[np.uint8]
    """(h, w, 3)"""
    identity: npt.NDArray[np.uint8]
    """(h, w): 0 = room or ground, n = the object with id n of the truth, 255 = the robot"""
    depth: npt.NDArray[np.float32]
    """(h, w) z-depth [m], 0 = unknown"""
    truth: dict[str, Any]
    """As in the truth file of `w2c scenes render`"""


class TruePictures:
    """Draws one scene after another; the stock of a block of seeds is compiled once."""

    def __init__(self, width: int, height: int) -> None:
        choose_backend()
        self._size = width, height
        self._pool: Pool | None = None
        self._block = -1

    def scene(self, seed: int) -> Scene:
        """Return the scene of a seed. Raises ConfigError for one that is not for judging."""
        if seed < FIRST_JUDGING_SEED:
            raise ConfigError(
                f"scene {seed} may be in a training set; those for judging begin at "
                f"{FIRST_JUDGING_SEED}"
            )
        return random_scene(seed, self._stock(seed).assets, 0.0)

    def draw(self, seed: int, *, outdoors: bool) -> TruePicture:
        """Return the picture of the scene of a seed. Raises ConfigError as `scene`."""
        scene = self.scene(seed)
        rng = np.random.default_rng([seed, 9])
        shadows = bool(rng.random() < SHADOW_SHARE)
        if outdoors:
            grounds = GROUNDS[self._stock(seed).floor]
            scene = under_the_sky(scene, grounds, np.random.default_rng([seed, 14]))
            shadows = True
        shot = self._stock(seed).shoot(scene, rng, shadows=shadows)
        return TruePicture(
            shot.image.rgb, shot.identity, shot.image.depth, truth(f"{seed:07d}", scene, shot)
        )

    def close(self) -> None:
        """Free the graphics context. Idempotent."""
        if self._pool is not None:
            self._pool.close()
            self._pool = None
            self._block = -1

    def _stock(self, seed: int) -> Pool:
        block = seed // SCENES_PER_STOCK
        if self._pool is None or block != self._block:
            self.close()
            self._pool, self._block = Pool(block, *self._size), block
        return self._pool


def stage_of(scene: Scene) -> str:
    """Return what the things stand on: the kind of the furniture, or `floor`."""
    first = scene.objects[0].kind
    return first if KINDS[first].furniture else "floor"


def under_the_sky(scene: Scene, grounds: Sequence[Colour], rng: np.random.Generator) -> Scene:
    """Return the same things on one of these grounds, under a sky with one sun."""
    ground = grounds[int(rng.integers(len(grounds)))]
    shade = float(rng.uniform(0.85, 1.1))
    haze = float(rng.uniform(0.0, 0.5))
    clear, pale = np.array((0.42, 0.66, 0.93)), np.array((0.82, 0.88, 0.94))
    sky = (1.0 - haze) * clear + haze * pale
    turn, flat = float(rng.uniform(-np.pi, np.pi)), float(rng.uniform(0.5, 1.0))
    direction = (flat * float(np.cos(turn)), flat * float(np.sin(turn)), -1.0)
    sun = Light(
        position=(0.7 - 2.6 * direction[0], -2.6 * direction[1], 3.2),
        direction=direction,
        brightness=float(rng.uniform(0.8, 1.0)),
        warmth=float(rng.uniform(0.2, 0.7)),
    )
    fill = Light(
        position=(0.7, 0.0, 3.2),
        direction=(0.0, 0.0, -1.0),
        brightness=0.15,
        warmth=-0.6,
        shadow=False,
    )
    red, green, blue = (min(1.0, shade * value) for value in ground)
    surroundings = Surroundings(
        floor=scene.surroundings.floor,
        floor_colour=(red, green, blue),
        wall_colour=(float(sky[0]), float(sky[1]), float(sky[2])),
        ambient=float(rng.uniform(0.42, 0.55)),
        variant=scene.surroundings.variant,
    )
    return msgspec.structs.replace(scene, lights=(sun, fill), surroundings=surroundings)
