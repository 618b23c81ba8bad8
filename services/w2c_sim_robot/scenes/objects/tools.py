"""Things of a workshop: toolbox, mallet, tray, crate, block."""

import numpy as np

from w2c_sim_robot.scenes.objects import textures
from w2c_sim_robot.scenes.objects.meshes import box, lathe, prism, rounded_rectangle, tube
from w2c_sim_robot.scenes.objects.shape import (
    Collider,
    Part,
    Shape,
    Size,
    Surface,
    box_collider,
    merged,
)
from w2c_sim_robot.scenes.objects.solids import open_wall, wall_colliders

STEEL = (0.62, 0.63, 0.65)
RUBBER = (0.10, 0.10, 0.11)
BEECH = (0.80, 0.60, 0.37)


def toolbox(size: Size, rng: np.random.Generator) -> Shape:
    """Return a closed toolbox: a lid with a handle on top, two latches in front; long along y."""
    x, y, z = size
    body = prism(rounded_rectangle(x, y, 0.02), 0.6 * z, 0.006)
    lid = prism(rounded_rectangle(0.97 * x, 0.98 * y, 0.02), 0.2 * z, 0.012).moved((0, 0, 0.6 * z))
    seam = prism(rounded_rectangle(1.004 * x, 1.003 * y, 0.02), 0.025 * z).moved((0, 0, 0.585 * z))
    latches = [
        box((0.008, 0.05 * y, 0.13 * z)).moved((-x / 2, side * 0.28 * y, 0.53 * z))
        for side in (-1, 1)
    ]
    top = 0.97 * z - 0.011
    grip = [
        [0, -0.2 * y, 0.78 * z],
        [0, -0.19 * y, 0.9 * z],
        [0, -0.15 * y, top],
        [0, 0.15 * y, top],
    ]
    grip += [[0, 0.19 * y, 0.9 * z], [0, 0.2 * y, 0.78 * z]]
    paint = textures.brushed(rng)
    return Shape(
        (
            Part(body, Surface("main", paint, 0.7)),
            Part(lid, Surface("main", paint, 0.7), "lid"),
            Part(seam, Surface(RUBBER, None, 0.3)),
            Part(tube(grip, 0.011), Surface(RUBBER, None, 0.3), "handle"),
            Part(merged(*latches), Surface(STEEL, None, 0.9), "latch"),
        ),
        (
            Collider("box", (x / 2, y / 2, 0.4 * z), (0, 0, 0.4 * z)),
            Collider("box", (0.012, 0.2 * y, 0.1 * z), (0, 0, 0.9 * z)),
        ),
    )


def mallet(size: Size, rng: np.random.Generator) -> Shape:
    """Return a mallet that lies on its side, its handle along x towards the robot."""
    x, y, z = size
    r = z / 2
    turned = lathe(
        [
            [0, -y / 2],
            [0.9 * r, -y / 2],
            [r, -0.46 * y],
            [r, 0.46 * y],
            [0.9 * r, y / 2],
            [0, y / 2],
        ]
    )
    upright = np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]])
    head = turned.rotated(upright).moved((x / 2 - r, 0, r))
    along = np.array([[0, 0, 1.0], [0, 1.0, 0], [-1.0, 0, 0]])
    stick = lathe(
        [
            [0, -x / 2],
            [0.42 * r, -x / 2],
            [0.46 * r, -0.3 * x],
            [0.34 * r, 0.0],
            [0.36 * r, x / 2 - r],
        ]
    )
    handle = stick.rotated(along).moved((0, 0, r))
    return Shape(
        (
            Part(head, Surface("main", textures.speckle(rng, 0.02), 0.15), "head"),
            Part(handle, Surface(BEECH, textures.wood(rng, 128, 128, 1), 0.3), "handle", "wood"),
        ),
        (
            Collider("box", (r, y / 2, r), (x / 2 - r, 0, r)),
            # Deeper than it looks, for the end of the handle rests on the table.
            Collider("box", (x / 2 - r, 0.42 * r, 0.71 * r), (-r, 0, 0.71 * r)),
        ),
    )


def tray(size: Size, rng: np.random.Generator) -> Shape:
    """Return a flat tray with a rim and two grips."""
    x, y, z = size
    floor = prism(rounded_rectangle(x, y, 0.03), 0.15 * z, 0.0005)
    rim = open_wall(x, y, z, 0.03, 0.008)
    return Shape(
        (
            Part(floor, Surface("main", textures.speckle(rng, 0.01), 0.45)),
            Part(rim, Surface("main", None, 0.45)),
        ),
        (
            Collider("box", (x / 2, y / 2, 0.075 * z), (0, 0, 0.075 * z)),
            *wall_colliders(size, 0.008),
        ),
    )


def crate(size: Size, rng: np.random.Generator) -> Shape:
    """Return an open crate with slatted walls."""
    x, y, z = size
    slats = [
        open_wall(x, y, 0.26 * z, 0.006, 0.009).moved((0, 0, k * 0.345 * z + 0.025 * z))
        for k in range(3)
    ]
    posts = [
        box((0.014, 0.014, z)).moved((a * (x / 2 - 0.014), b * (y / 2 - 0.014), 0))
        for a in (-1, 1)
        for b in (-1, 1)
    ]
    floor = box((0.96 * x, 0.96 * y, 0.05 * z)).moved((0, 0, 0.005))
    return Shape(
        (
            Part(merged(*slats), Surface("main", textures.wood(rng, 128, 512, 1), 0.15)),
            Part(merged(floor, *posts), Surface("main", None, 0.15)),
        ),
        (
            Collider("box", (x / 2, y / 2, 0.05 * z), (0, 0, 0.05 * z)),
            *wall_colliders(size, 0.012),
        ),
    )


def block(size: Size, rng: np.random.Generator) -> Shape:
    """Return a painted wooden block."""
    body = prism(rounded_rectangle(size[0], size[1], 0.006), size[2], 0.004)
    return Shape(
        (Part(body, Surface("main", textures.wood(rng, 128, 128, 1), 0.3)),), (box_collider(size),)
    )
