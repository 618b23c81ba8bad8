"""Balls, cloth, sponges, fruit."""

import numpy as np

from w2c_sim_robot.scenes.objects import textures
from w2c_sim_robot.scenes.objects.meshes import lathe, prism, rounded_rectangle, sheet, tube
from w2c_sim_robot.scenes.objects.shape import Collider, Part, Shape, Size, Surface, box_collider

STALK = (0.30, 0.20, 0.10)


def ball(size: Size, rng: np.random.Generator) -> Shape:
    """Return a ball with a band around it."""
    r = size[2] / 2
    angle = np.linspace(-np.pi / 2, np.pi / 2, 25)
    body = lathe(np.column_stack([r * np.cos(angle), r + r * np.sin(angle)]))
    tilt = rng.uniform(0.2, 1.2)
    turn = np.array([[np.cos(tilt), 0, np.sin(tilt)], [0, 1, 0], [-np.sin(tilt), 0, np.cos(tilt)]])
    centred = body.moved((0, 0, -r)).rotated(turn).moved((0, 0, r))
    band = textures.rings(rng, bands=1 if rng.random() < 0.6 else 0)
    return Shape(
        (Part(centred, Surface("main", band, 0.5)),), (Collider("sphere", (r,), (0, 0, r)),)
    )


def cloth(size: Size, rng: np.random.Generator) -> Shape:
    """Return a cloth spread out with a few folds."""
    x, y, z = size
    rows, columns = 28, 28
    folds = textures.noise(rng, rows, columns, 12, 2)
    fold = 0.5 + 0.5 * np.tanh(folds)
    heights = 0.0015 + (z - 0.0015) * fold
    return Shape(
        (
            Part(
                sheet(heights, size),
                Surface("main", textures.weave(rng, stripes=int(rng.integers(0, 3))), 0.02),
            ),
        ),
        (box_collider((x, y, 0.5 * z)),),
    )


def sponge(size: Size, rng: np.random.Generator) -> Shape:
    """Return a sponge with a scouring side underneath."""
    x, y, z = size
    outline = rounded_rectangle(x, y, 0.012)
    return Shape(
        (
            Part(
                prism(outline, 0.75 * z, 0.003).moved((0, 0, 0.25 * z)),
                Surface("main", textures.speckle(rng, 0.06, 6.0), 0.02),
            ),
            Part(
                prism(outline, 0.25 * z, 0.002),
                Surface((0.16, 0.30, 0.20), textures.speckle(rng, 0.08, 3.0), 0.02),
            ),
        ),
        (box_collider(size),),
    )


def apple(size: Size, rng: np.random.Generator) -> Shape:
    """Return an apple with its stalk."""
    r, z = size[1] / 2, size[2]
    t = np.linspace(0, np.pi, 22)
    wide = r * np.sin(t) ** 0.8 * (1.0 + 0.08 * np.cos(t) * -1)
    high = (
        0.46 * z * (1 - np.cos(t))
        - 0.1 * z * np.exp(-((t - np.pi) ** 2) / 0.12)
        + 0.03 * z * np.exp(-(t**2) / 0.1)
    )
    high = high - high.min()
    body = lathe(np.column_stack([np.maximum(wide, 0), high]))
    stalk = tube([[0, 0, 0.8 * z], [0.02 * r, 0, 0.9 * z], [0.12 * r, 0.05 * r, z]], 0.05 * r, 6)
    return Shape(
        (
            Part(body, Surface("main", textures.speckle(rng, 0.05, 10.0), 0.7)),
            Part(stalk, Surface(STALK, None, 0.1), "stalk"),
        ),
        (Collider("sphere", (min(r, 0.46 * z),), (0, 0, 0.46 * z)),),
    )
