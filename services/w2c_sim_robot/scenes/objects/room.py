"""Shelves, seats, walls and what hangs on them."""

import numpy as np

from w2c_sim_robot.scenes.objects import textures
from w2c_sim_robot.scenes.objects.meshes import box, lathe, strips
from w2c_sim_robot.scenes.objects.shape import (
    Collider,
    Mesh,
    Part,
    Points,
    Shape,
    Size,
    Surface,
    box_collider,
    fitted,
    merged,
)
from w2c_sim_robot.scenes.objects.solids import rod, slab

SHELF_BOARD = 0.024
SHELF_LEVELS = (0.05, 0.46, 1.0)
"""Upper sides of the boards of a shelf, as a share of its height"""


def shelf(size: Size, rng: np.random.Generator) -> Shape:
    """Return an open shelf: two sides, a board at each of `SHELF_LEVELS`."""
    x, y, z = size
    grain = textures.wood(rng, 512, 512, 2)
    boards = [
        slab(x, y - 0.04, SHELF_BOARD, 0.002, 0.001).moved((0, 0, level * z - SHELF_BOARD))
        for level in SHELF_LEVELS
    ]
    sides = [
        slab(x, 0.02, z - 0.002, 0.002, 0.001).moved((0, s * (y / 2 - 0.01), 0)) for s in (-1, 1)
    ]
    half = SHELF_BOARD / 2
    return Shape(
        (
            Part(merged(*boards), Surface("main", grain, 0.25), "board"),
            Part(merged(*sides), Surface("main", grain, 0.25)),
        ),
        (
            *(
                Collider("box", (x / 2, y / 2 - 0.02, half), (0, 0, level * z - half))
                for level in SHELF_LEVELS
            ),
            *(
                Collider("box", (x / 2, 0.01, z / 2), (0, s * (y / 2 - 0.01), z / 2))
                for s in (-1, 1)
            ),
        ),
    )


def stool(size: Size, rng: np.random.Generator) -> Shape:
    """Return a stool: a round seat on four legs with a ring of rungs."""
    r, z = size[1] / 2, size[2]
    seat = lathe([[0, z - 0.04], [0.93 * r, z - 0.04], [r, z - 0.02], [0.95 * r, z], [0, z]])
    feet = [np.array([np.cos(a), np.sin(a)]) for a in np.pi / 4 + np.pi / 2 * np.arange(4)]
    legs = [
        rod([[*(0.93 * r * f), 0.0], [*(0.62 * r * f), z - 0.03]], np.array([0.016, 0.02]), 10)
        for f in feet
    ]
    rungs = [
        rod([[*(0.82 * r * f), 0.34 * z], [*(0.82 * r * g), 0.34 * z]], 0.01, 8)
        for f, g in zip(feet, [*feet[1:], feet[0]], strict=True)
    ]
    grain = textures.wood(rng, 256, 256, 2)
    return fitted(
        size,
        (
            Part(seat, Surface("main", grain, 0.35), "seat"),
            Part(merged(*legs), Surface("main", grain, 0.35), "leg"),
            Part(merged(*rungs), Surface("main", None, 0.35)),
        ),
        (
            Collider("cylinder", (r, 0.02), (0, 0, z - 0.02)),
            *(
                Collider(
                    "box", (0.018, 0.018, (z - 0.04) / 2), (*(0.7 * r * f).tolist(), (z - 0.04) / 2)
                )
                for f in feet
            ),
        ),
    )


def wall(size: Size, rng: np.random.Generator) -> Shape:
    """Return a piece of wall with a skirting board towards the robot."""
    x, y, z = size
    bricks = rng.random() < 0.4
    texture = textures.brick_wall(rng) if bricks else textures.speckle(rng, 0.012, 60, 256)
    skirting = slab(0.016, y, 0.08, 0.004, 0.002).moved((-x / 2 + 0.001, 0, 0))
    return fitted(
        size,
        (
            Part(box((x - 0.014, y, z)).moved((0.007, 0, 0)), Surface("main", texture, 0.05)),
            Part(skirting, Surface((0.9, 0.9, 0.88), None, 0.4), "skirting board"),
        ),
        (box_collider(size),),
    )


def window(size: Size, rng: np.random.Generator) -> Shape:
    """Return a window in its frame: four panes with the sky behind."""
    x, y, z = size
    bar = 0.045
    frame = [box((x, bar, z)).moved((0, s * (y - bar) / 2, 0)) for s in (-1, 1)] + [
        box((x, y - 2 * bar, bar)).moved((0, 0, h)) for h in (0.0, z - bar)
    ]
    cross = [
        box((0.8 * x, 0.6 * bar, z - 2 * bar)).moved((0, 0, bar)),
        box((0.8 * x, y - 2 * bar, 0.6 * bar)).moved((0, 0, z / 2 - 0.3 * bar)),
    ]
    pane = box((0.2 * x, y - 2 * bar, z - 2 * bar), ("-x", "+x")).moved((0, 0, bar))
    rows = np.linspace(0, 1, 192)[:, None, None]
    sky = np.array([150, 190, 230]) * (1 - rows) + np.array([226, 236, 243]) * rows
    picture = np.repeat(sky, 160, axis=1)
    clouds = np.clip(textures.noise(rng, 192, 160, 50), 0, 1)[:, :, None]
    picture = picture + clouds * (250 - picture) * 0.7
    return Shape(
        (
            Part(merged(*frame, *cross), Surface("main", None, 0.4), "frame"),
            Part(pane, Surface((1.0, 1.0, 1.0), picture.astype(np.uint8), 1.0), "pane", "glass"),
        ),
        (box_collider(size),),
    )


def poster(size: Size, rng: np.random.Generator) -> Shape:
    """Return a framed picture of hills under a sun."""
    x, y, z = size
    bar = 0.02
    frame = [box((x, bar, z)).moved((0, s * (y - bar) / 2, 0)) for s in (-1, 1)]
    frame += [box((x, y - 2 * bar, bar)).moved((0, 0, h)) for h in (0.0, z - bar)]
    image = np.full((240, 180, 3), (236, 214, 180), np.uint8)
    rows, columns = np.mgrid[0:240, 0:180]
    sun = (rows - 70) ** 2 + (columns - rng.uniform(40, 140)) ** 2 < 26**2
    image[sun] = (226, 120, 60)
    for shade, level in (((150, 160, 150), 120), ((100, 125, 110), 160), ((60, 85, 75), 200)):
        ridge = level + 16 * np.sin(columns / rng.uniform(12, 40) + rng.uniform(0, 6))
        image[rows > ridge] = shade
    inner = box((0.5 * x, y - 2 * bar, z - 2 * bar), ("-x",)).moved((0, 0, bar))
    back = box((0.4 * x, y - bar, z - bar), ("+x",)).moved((0.3 * x, 0, bar / 2))
    return Shape(
        (
            Part(merged(*frame, back), Surface("main", None, 0.5), "frame"),
            Part(inner, Surface((1.0, 1.0, 1.0), image, 0.2)),
        ),
        (box_collider(size),),
    )


def drape(size: Size, rng: np.random.Generator) -> Shape:
    """Return a cloth spread over an edge: it lies at the top and hangs down at its near side."""
    x, y, z = size
    r = 0.02
    bend = np.linspace(0.0, np.pi / 2, 7)
    corner = np.column_stack([-x / 2 + r - r * np.cos(bend), z - r + r * np.sin(bend)])
    hanging = np.column_stack([np.full(9, -x / 2), np.linspace(0, z - r, 10)[:-1]])
    lying = np.column_stack([np.linspace(-x / 2 + r, x / 2, 20)[1:], np.full(19, z)])
    path = np.vstack([hanging, corner, lying])
    columns = 32
    across = np.linspace(-0.5, 0.5, columns)
    phase = rng.uniform(0, 6)
    waves = np.sin(2 * np.pi * 3.5 * across + phase) + 0.5 * np.sin(2 * np.pi * 6 * across)
    folds = textures.noise(rng, len(path), columns, 10, 2)
    hang = np.clip((z - path[:, 1]) / z, 0, 1)
    surface = np.zeros((len(path), columns, 3))
    surface[:, :, 0] = path[:, None, 0] + 0.012 * hang[:, None] * (waves[None, :] - 1.2)
    surface[:, :, 1] = across[None, :] * y
    surface[:, :, 2] = path[:, None, 1] - 0.002 + 0.0015 * np.tanh(folds) * (1 - hang[:, None])
    along, over = np.gradient(surface, axis=0), np.gradient(surface, axis=1)
    normals = np.cross(along, over)
    normals = normals / np.linalg.norm(normals, axis=2, keepdims=True)
    share = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    share = share / share[-1]
    rows = [surface[:, j] for j in range(columns)]
    lean = [normals[:, j] for j in range(columns)]
    texcoords = [
        np.column_stack([np.full(len(path), 1 - j / (columns - 1)), 1 - share])
        for j in range(columns)
    ]
    outside = strips(rows, lean, texcoords)
    inside = Mesh(
        outside.vertices - 1.2e-3 * outside.normals,
        -outside.normals,
        outside.texcoords,
        outside.faces[:, ::-1],
    )
    weave = textures.weave(rng, stripes=1)
    return fitted(
        size,
        (Part(merged(outside, inside), Surface("main", weave, 0.02)),),
        (
            Collider("box", (x / 2, y / 2, 0.002), (0, 0, z - 0.002)),
            Collider("box", (0.003, 0.48 * y, 0.45 * z), (-x / 2 - 0.012, 0, 0.5 * z)),
        ),
    )


def shelf_heights(size: Size) -> Points:
    """Return the heights (3,) of the boards of a shelf of this size [m]."""
    return np.asarray(SHELF_LEVELS) * size[2]
