"""Appliances, shelves, walls and what hangs on them."""

from itertools import pairwise

import numpy as np

from w2c_sim_robot.scenes.objects import textures
from w2c_sim_robot.scenes.objects.meshes import box, lathe, prism, rounded_rectangle, strips
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
from w2c_sim_robot.scenes.objects.solids import disc, rod, slab

STEEL = (0.70, 0.71, 0.73)
DARK = (0.13, 0.13, 0.14)
DOOR_SHARE = 0.48
"""Of the length of an open dishwasher: its door, folded down before it"""
DOOR_TOP = 0.19
"""Height of the upper side of the open door [m]"""
SHELF_BOARD = 0.024
SHELF_LEVELS = (0.05, 0.46, 1.0)
"""Upper sides of the boards of a shelf, as a share of its height"""
WIRE = 0.0022
"""Radius of the wires of a dish rack [m]"""
RACK_FLOOR = 0.026
"""Height of a dish rack's floor above its wheels [m]"""


def dishwasher(size: Size, rng: np.random.Generator) -> Shape:
    """Return an open dishwasher: the machine at +x, its door folded down towards the robot."""
    x, y, z = size
    door = DOOR_SHARE * x
    depth = x - door
    middle = door / 2  # of the machine, along x
    wall = 0.03
    top = slab(depth, y, 0.035, 0.008, 0.004).moved((middle, 0, z - 0.035))
    sides = [box((depth, wall, z - 0.035)).moved((middle, s * (y - wall) / 2, 0)) for s in (-1, 1)]
    back = box((wall, y - 2 * wall, z - 0.035)).moved((x / 2 - wall / 2, 0, 0))
    floor = box((depth - wall, y - 2 * wall, DOOR_TOP)).moved((middle - wall / 2, 0, 0))
    lining = box((4e-4, y - 2 * wall, z - DOOR_TOP - 0.035), ("-x",)).moved(
        (x / 2 - wall - 4e-4, 0, DOOR_TOP)
    )
    tub = box((depth - wall, y - 2 * wall, 4e-4), ("+z",)).moved((middle - wall / 2, 0, DOOR_TOP))
    inner_sides = [
        box((depth - wall, 4e-4, z - DOOR_TOP - 0.035), (face,)).moved(
            (middle - wall / 2, s * (y / 2 - wall - 4e-4), DOOR_TOP)
        )
        for s, face in ((1, "-y"), (-1, "+y"))
    ]
    flap = slab(door + 0.01, 0.97 * y, 0.045, 0.012, 0.006).moved(
        (-x / 2 + door / 2 + 0.005, 0, DOOR_TOP - 0.045)
    )
    inside = prism(rounded_rectangle(0.86 * door, 0.86 * y, 0.02), 0.003).moved(
        (-x / 2 + door / 2, 0, DOOR_TOP)
    )
    feet = [
        box((0.03, 0.03, DOOR_TOP - 0.045)).moved((-x / 2 + 0.04, s * 0.4 * y, 0)) for s in (-1, 1)
    ]
    basin = Surface(STEEL, textures.brushed(rng), 0.8)
    return Shape(
        (
            Part(top, Surface("main", textures.speckle(rng, 0.006), 0.4), "top"),
            Part(merged(*sides, back, floor), Surface("main", None, 0.4)),
            Part(flap, Surface("main", None, 0.4), "door"),
            Part(merged(lining, tub, inside, *inner_sides), basin, "inside", "metal"),
            Part(merged(*feet), Surface(DARK, None, 0.2)),
        ),
        (
            Collider("box", (depth / 2, y / 2, 0.0175), (middle, 0, z - 0.0175)),
            *(
                Collider(
                    "box",
                    (depth / 2, wall / 2, (z - 0.035) / 2),
                    (middle, s * (y - wall) / 2, (z - 0.035) / 2),
                )
                for s in (-1, 1)
            ),
            Collider(
                "box",
                (wall / 2, y / 2 - wall, (z - 0.035) / 2),
                (x / 2 - wall / 2, 0, (z - 0.035) / 2),
            ),
            Collider("box", (depth / 2, y / 2 - wall, DOOR_TOP / 2), (middle, 0, DOOR_TOP / 2)),
            Collider(
                "box", (door / 2, 0.485 * y, 0.0225), (-x / 2 + door / 2, 0, DOOR_TOP - 0.0225)
            ),
        ),
    )


def dish_rack(size: Size, _rng: np.random.Generator) -> Shape:
    """Return a wire rack on wheels, with prongs that plates stand between."""
    x, y, z = size
    a, b = x / 2 - WIRE, y / 2 - WIRE
    corners = np.array([[-a, -b], [a, -b], [a, b], [-a, b], [-a, -b]])
    wires = []
    for height in (RACK_FLOOR, 0.6 * z, z - WIRE):
        for start, end in pairwise(corners):
            wires.append(rod([[*start, height], [*end, height]], WIRE, 6))
    for share in np.linspace(-1, 1, 9):
        wires.append(rod([[share * a, -b, z - WIRE], [share * a, -b, RACK_FLOOR]], WIRE, 6))
        wires.append(rod([[share * a, b, z - WIRE], [share * a, b, RACK_FLOOR]], WIRE, 6))
        wires.append(rod([[share * a, -b, RACK_FLOOR], [share * a, b, RACK_FLOOR]], WIRE, 6))
        wires.append(rod([[-a, share * b, z - WIRE], [-a, share * b, RACK_FLOOR]], WIRE, 6))
        wires.append(rod([[a, share * b, z - WIRE], [a, share * b, RACK_FLOOR]], WIRE, 6))
        wires.append(rod([[-a, share * b, RACK_FLOOR], [a, share * b, RACK_FLOOR]], WIRE, 6))
    for along in np.linspace(-0.8, 0.8, 7) * a:
        for across in np.linspace(-0.75, 0.75, 4) * b:
            foot = [along, across, RACK_FLOOR]
            wires.append(rod([foot, [along + 0.012, across, RACK_FLOOR + 0.07]], WIRE, 6))
    wheel = lathe([[0.006, -0.004], [0.016, -0.004], [0.016, 0.004], [0.006, 0.004]])
    upright = np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]])
    wheels = [
        wheel.rotated(upright).moved((s * 0.8 * a, t * (b - 0.004), 0.016))
        for s in (-1, 1)
        for t in (-1, 1)
    ]
    thick = 0.004
    return Shape(
        (
            Part(merged(*wires), Surface("main", None, 0.7)),
            Part(merged(*wheels), Surface(DARK, None, 0.3), "wheel"),
        ),
        (
            Collider("box", (x / 2, y / 2, RACK_FLOOR / 2), (0, 0, RACK_FLOOR / 2)),
            *(
                Collider("box", (thick / 2, y / 2, z / 2), (s * (x - thick) / 2, 0, z / 2))
                for s in (-1, 1)
            ),
            *(
                Collider("box", (x / 2, thick / 2, z / 2), (0, s * (y - thick) / 2, z / 2))
                for s in (-1, 1)
            ),
        ),
    )


def fridge(size: Size, rng: np.random.Generator) -> Shape:
    """Return a small fridge with its door towards the robot."""
    x, y, z = size
    body = prism(rounded_rectangle(x - 0.05, y, 0.02), z, 0.006).moved((0.025, 0, 0))
    door = prism(rounded_rectangle(0.046, y, 0.015), z - 0.06, 0.005).moved(
        (-x / 2 + 0.023 + 0.008, 0, 0.04)
    )
    plinth = box((0.04, 0.92 * y, 0.04)).moved((-x / 2 + 0.07, 0, 0))
    grip = rod(
        [[-x / 2 + 0.012, 0.4 * y, h] for h in (0.56 * z, 0.6 * z)]
        + [[-x / 2 + 0.007, 0.4 * y, h] for h in (0.62 * z, 0.84 * z)]
        + [[-x / 2 + 0.012, 0.4 * y, h] for h in (0.86 * z, 0.9 * z)],
        0.007,
    )
    enamel = Surface("main", textures.speckle(rng, 0.006), 0.5)
    return Shape(
        (
            Part(body, enamel),
            Part(door, enamel, "door"),
            Part(grip, Surface(STEEL, None, 1.0), "handle", "metal"),
            Part(plinth, Surface(DARK, None, 0.2)),
        ),
        (box_collider(size),),
    )


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


def hot_plate(size: Size, rng: np.random.Generator) -> Shape:
    """Return an electric hob with two plates, one of them glowing."""
    x, y, z = size
    body = slab(x, y, 0.8 * z, 0.012, 0.004)
    rings = []
    for side in (-1, 1):
        r = 0.36 * min(x, y / 2)
        plate = lathe([[0, 0], [r, 0], [r, 0.2 * z], [0.96 * r, 0.2 * z], [0, 0.2 * z]])
        rings.append(plate.moved((0, side * 0.24 * y, 0.8 * z)))
    glow = []
    r = 0.36 * min(x, y / 2)
    for inner in (0.2, 0.5, 0.8):
        glow.append(lathe([[(inner + 0.14) * r, 0], [inner * r, 0]]).moved((0, 0.24 * y, z + 3e-4)))
    knobs = [
        disc(np.array([-x / 2 - 1e-3, place * y, 0.4 * z]), np.array([-1.0, 0, 0]), 0.25 * z, 20)
        for place in (-0.3, 0.3)
    ]
    return Shape(
        (
            Part(body, Surface("main", textures.speckle(rng, 0.006), 0.6)),
            Part(merged(*rings), Surface(DARK, textures.speckle(rng, 0.03), 0.4), "plate", "metal"),
            Part(merged(*glow), Surface((0.95, 0.20, 0.05), None, 0.0), "hot plate"),
            Part(merged(*knobs), Surface("accent", None, 0.4), "knob"),
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
