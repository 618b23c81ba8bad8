"""What stands in a kitchen beside the crockery: glasses, pans, pots, boards, food."""

import numpy as np

from w2c_sim_robot.scenes.objects import textures
from w2c_sim_robot.scenes.objects.meshes import arc, box, lathe, prism, rounded_rectangle, tube
from w2c_sim_robot.scenes.objects.shape import (
    Collider,
    Mesh,
    Part,
    Shape,
    Size,
    Surface,
    box_collider,
    cylinder_collider,
    fitted,
    merged,
)
from w2c_sim_robot.scenes.objects.solids import ellipsoid, polygon, rod, slab, turned

STEEL = (0.70, 0.71, 0.73)
BAKELITE = (0.10, 0.10, 0.11)
CRUST = (0.72, 0.47, 0.22)


def glass(size: Size, _rng: np.random.Generator) -> Shape:
    """Return a tumbler that one can see through."""
    r, z = size[1] / 2, size[2]
    outer = lathe([[0, 0], [0.78 * r, 0], [0.82 * r, 0.02 * z], [r, z]])
    inner = lathe([[r, z], [0.94 * r, z], [0.76 * r, 0.08 * z], [0, 0.08 * z]])
    rim = lathe([[0.999 * r, 0.985 * z], [r, z], [0.94 * r, z], [0.935 * r, 0.985 * z]])
    clear = Surface("main", None, 1.0, 0.45)
    return Shape(
        (
            Part(rim, Surface("main", None, 1.0), "rim"),
            Part(inner, clear),
            Part(outer, clear),
        ),
        (cylinder_collider(size),),
    )


def jar(size: Size, rng: np.random.Generator) -> Shape:
    """Return a jar of jam with a paper label and a checked lid."""
    r, z = size[1] / 2, size[2]
    body = lathe(
        [[0, 0], [0.9 * r, 0], [r, 0.06 * z], [r, 0.7 * z], [0.84 * r, 0.8 * z], [0, 0.8 * z]]
    )
    lid = lathe([[0.9 * r, 0.79 * z], [0.9 * r, 0.97 * z], [0.85 * r, z], [0, z]])
    label = lathe([[1.015 * r, 0.16 * z], [1.015 * r, 0.6 * z]])
    return Shape(
        (
            Part(body, Surface("main", textures.speckle(rng, 0.03), 0.95)),
            Part(lid, Surface((0.82, 0.80, 0.74), textures.brushed(rng), 0.8), "lid", "metal"),
            Part(label, Surface((0.96, 0.95, 0.90), textures.label(rng), 0.1), "label"),
        ),
        (cylinder_collider(size),),
    )


def pan(size: Size, rng: np.random.Generator) -> Shape:
    """Return a frying pan, its long handle towards the robot."""
    r, z = 0.13, 0.05
    outer = lathe([[0, 0], [0.8 * r, 0], [0.86 * r, 0.08 * z], [r, 0.98 * z], [r, z]])
    inner = lathe([[r, z], [0.97 * r, z], [0.8 * r, 0.12 * z], [0, 0.12 * z]])
    grip = rod([[-0.95 * r, 0, 0.7 * z], [-1.3 * r, 0, 1.05 * z], [-2.5 * r, 0, 1.25 * z]], 0.011)
    return fitted(
        size,
        (
            Part(outer, Surface("main", textures.brushed(rng), 0.7)),
            Part(inner, Surface((0.13, 0.13, 0.14), textures.speckle(rng, 0.03), 0.35)),
            Part(grip, Surface(BAKELITE, None, 0.4), "handle", "plastic"),
        ),
        (
            Collider("cylinder", (0.9 * r, z / 2), (0, 0, z / 2)),
            Collider("box", (0.7 * r, 0.01, 0.01), (-1.75 * r, 0, 1.15 * z)),
        ),
    )


def pot(size: Size, rng: np.random.Generator) -> Shape:
    """Return a cooking pot with two ears and a lid with a knob."""
    r, z = 0.11, 0.13
    body = lathe([[0, 0], [0.94 * r, 0], [r, 0.06 * z], [r, z], [1.03 * r, 1.02 * z]])
    lid = lathe(
        [
            [1.02 * r, 1.02 * z],
            [1.02 * r, 1.06 * z],
            [0.7 * r, 1.18 * z],
            [0.12 * r, 1.25 * z],
            [0, 1.25 * z],
        ]
    )
    knob = lathe([[0.1 * r, 0], [0.09 * r, 0.06 * z], [0.2 * r, 0.12 * z], [0.16 * r, 0.2 * z]])
    knob = merged(knob, lathe([[0.16 * r, 0.2 * z], [0, 0.21 * z]])).moved((0, 0, 1.24 * z))
    turn = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    flat = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    ear = tube(arc((r, 0, 0), (0.32 * r, 0.42 * r), -0.5 * np.pi, 0.5 * np.pi), 0.009)
    ears = [
        ear.rotated(flat).rotated(np.linalg.matrix_power(turn, quarter)).moved((0, 0, 0.82 * z))
        for quarter in (1, 3)
    ]
    return fitted(
        size,
        (
            Part(body, Surface("main", textures.brushed(rng), 0.9)),
            Part(lid, Surface("main", textures.brushed(rng), 0.9), "lid"),
            Part(knob, Surface(BAKELITE, None, 0.4), "knob"),
            Part(merged(*ears), Surface(BAKELITE, None, 0.4), "handle"),
        ),
        (
            Collider("cylinder", (r, 0.5 * z), (0, 0, 0.5 * z)),
            Collider("cylinder", (0.5 * r, 0.14 * z), (0, 0, 1.14 * z)),
        ),
    )


def teapot(size: Size, rng: np.random.Generator) -> Shape:
    """Return a bellied teapot: spout to the right, handle to the left, a lid with a knob."""
    r, z = 0.075, 0.12
    t = np.linspace(0.06, 0.94, 16)
    belly = np.column_stack([r * np.sin(np.pi * t) ** 0.6, z * (1 - np.cos(np.pi * t)) / 2])
    body = lathe(np.vstack([[[0, belly[0, 1]]], belly]))
    foot = lathe([[0.62 * r, 0], [0.55 * r, 0.04 * z]])
    foot = merged(lathe([[0, 0], [0.62 * r, 0]]), foot)
    lid = lathe(
        [[0.56 * r, 0.93 * z], [0.5 * r, 0.98 * z], [0.12 * r, 1.03 * z], [0.12 * r, 1.06 * z]]
    )
    knob = ellipsoid((0.16 * r, 0.16 * r, 0.14 * r)).moved((0, 0, 1.1 * z))
    turn = np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]])
    spout = rod(
        [
            [0.8 * r, 0, 0.35 * z],
            [1.3 * r, 0, 0.48 * z],
            [1.5 * r, 0, 0.75 * z],
            [1.75 * r, 0, 0.95 * z],
        ],
        0.012,
    ).rotated(turn)
    ear = tube(arc((-0.82 * r, 0, 0.55 * z), (0.65 * r, 0.36 * z), 0.5 * np.pi, 1.5 * np.pi), 0.008)
    glaze = textures.rings(rng, bands=1)
    return fitted(
        size,
        (
            Part(merged(body, foot), Surface("main", glaze, 0.85)),
            Part(merged(lid, knob), Surface("main", glaze, 0.85), "lid"),
            Part(spout, Surface("main", glaze, 0.85), "spout"),
            Part(ear.rotated(turn), Surface("main", glaze, 0.85), "handle"),
        ),
        (Collider("cylinder", (0.9 * r, 0.5 * z), (0, 0, 0.5 * z)),),
    )


def cutting_board(size: Size, rng: np.random.Generator) -> Shape:
    """Return a chopping board with a dark groove and a grip at its near end."""
    x, y, z = size
    board = slab(x, y, z, 0.02, 0.003)
    groove = prism(rounded_rectangle(0.86 * x, 0.86 * y, 0.015), 2e-4).moved((0, 0, z))
    inside = prism(rounded_rectangle(0.83 * x, 0.82 * y, 0.012), 3e-4).moved((0, 0, z))
    grip = prism(rounded_rectangle(0.03 * x + 0.012, 0.3 * y, 0.01), 3e-4).moved((-0.465 * x, 0, z))
    grain = textures.wood(rng, 384, 384, 3)
    return Shape(
        (
            Part(board, Surface("main", grain, 0.2)),
            Part(merged(groove, grip), Surface((0.28, 0.19, 0.11), None, 0.1), "groove"),
            Part(inside, Surface("main", grain, 0.2)),
        ),
        (box_collider(size),),
    )


def cheez_it_box(size: Size, rng: np.random.Generator) -> Shape:
    """Return an upright box of cheese crackers: large print over square crackers, on both faces."""
    x, y, z = size
    brand = textures.words(
        ("CHEEZ-IT",), (320, 96), ink=(0.75, 0.06, 0.08), ground=(0.99, 0.96, 0.86)
    )
    crackers = np.full((150, 256, 3), (255, 244, 214), np.uint8)
    for row in range(3):
        for column in range(5):
            top = 5 + 48 * row + int(rng.integers(-3, 4))
            left = 10 + 49 * column + int(rng.integers(-3, 4))
            crackers[top : top + 40, left : left + 40] = (236, 148, 34)
            crackers[top + 17 : top + 23, left + 17 : left + 23] = (160, 84, 12)
    faces = ("-x", "+x")
    banner = box((x + 8e-4, 0.88 * y, 0.2 * z), faces).moved((0, 0, 0.68 * z))
    panel = box((x + 8e-4, 0.8 * y, 0.42 * z), faces).moved((0, 0, 0.12 * z))
    return Shape(
        (
            Part(box(size), Surface("main", textures.speckle(rng, 0.01), 0.4)),
            Part(banner, Surface((1.0, 1.0, 1.0), brand, 0.4), "print"),
            Part(panel, Surface((1.0, 1.0, 1.0), crackers, 0.4)),
        ),
        (box_collider(size),),
    )


def milk_carton(size: Size, rng: np.random.Generator) -> Shape:
    """Return a carton of milk with a gable top and a screw cap."""
    x, y, z = 0.072, 0.072, 0.235
    body = 0.76 * z
    front = textures.words(
        ("MILK", "1 L"), (192, 384), ink=(0.1, 0.2, 0.5), ground=(0.97, 0.97, 0.97)
    )
    ridge = _gable(x, y, body, 0.94 * z)
    fold = box((0.006, y, 0.075 * z)).moved((0, 0, 0.925 * z))
    cap = turned([[0.011, 0], [0.011, 0.012], [0, 0.012]], "x").moved((0, 0, 0))
    tilt = np.arctan2(0.5 * x, 0.94 * z - body)
    lean = np.array(
        [[-np.cos(tilt), 0, -np.sin(tilt)], [0, -1, 0], [-np.sin(tilt), 0, np.cos(tilt)]]
    )
    return fitted(
        size,
        (
            Part(box((x, y, body), ("-x", "+x")), Surface("main", front, 0.35), "front"),
            Part(
                merged(box((x, y, body), ("-y", "+y", "-z")), ridge, fold),
                Surface("main", textures.speckle(rng, 0.008), 0.35),
            ),
            Part(
                cap.rotated(lean).moved((-0.25 * x, 0, 0.5 * (body + 0.94 * z))),
                Surface("accent", None, 0.5),
                "cap",
            ),
        ),
        (
            Collider("box", (x / 2, y / 2, body / 2), (0, 0, body / 2)),
            Collider("box", (0.2 * x, y / 2, 0.12 * z), (0, 0, 0.88 * z)),
        ),
    )


def _gable(x: float, y: float, low: float, high: float) -> Mesh:
    """Return the two slopes and the two gables of a roof whose ridge runs along y."""
    a, b = x / 2, y / 2
    return merged(
        polygon([[a, -b, low], [a, b, low], [0, b, high], [0, -b, high]]),
        polygon([[-a, b, low], [-a, -b, low], [0, -b, high], [0, b, high]]),
        polygon([[a, b, low], [-a, b, low], [0, b, high]]),
        polygon([[-a, -b, low], [a, -b, low], [0, -b, high]]),
    )


def banana(size: Size, rng: np.random.Generator) -> Shape:
    """Return a banana that lies on its side."""
    angle = np.linspace(-0.62, 0.62, 24)
    middle = np.column_stack([0.16 * (np.cos(angle) - 0.9), 0.16 * np.sin(angle), 0 * angle])
    thick = 0.019 * np.clip(1.25 * np.cos(angle * 1.9), 0.28, 1.0)
    body = rod(middle, thick, 14)
    ends = [ellipsoid((0.007, 0.009, 0.007)).moved((*middle[i, :2].tolist(), 0.0)) for i in (0, -1)]
    return fitted(
        size,
        (
            Part(body, Surface("main", textures.speckle(rng, 0.02, 8), 0.3)),
            Part(merged(*ends), Surface((0.25, 0.17, 0.08), None, 0.1), "stalk"),
        ),
        tuple(
            Collider("box", (0.02, 0.028, 0.017), (float(middle[i, 0]), float(middle[i, 1]), 0))
            for i in (4, 11, 19)
        ),
    )


def bread(size: Size, rng: np.random.Generator) -> Shape:
    """Return a loaf with three cuts across its back."""
    loaf = ellipsoid((0.055, 0.13, 0.06), -25, 90)
    around = np.linspace(0.0, -2.0 * np.pi, 40, endpoint=False)
    wide = np.cos(np.radians(25))
    below = polygon(
        np.column_stack(
            [
                0.055 * wide * np.cos(around),
                0.13 * wide * np.sin(around),
                np.full(40, -0.06 * np.sin(np.radians(25))),
            ]
        )
    )
    cuts = [
        ellipsoid((0.035, 0.007, 0.008)).moved((0, place, 0.056 * np.sqrt(1 - (place / 0.13) ** 2)))
        for place in (-0.06, 0.0, 0.06)
    ]
    crust = textures.speckle(rng, 0.06, 30)
    return fitted(
        size,
        (
            Part(merged(loaf, below), Surface("main", crust, 0.15)),
            Part(merged(*cuts), Surface((0.93, 0.82, 0.62), None, 0.05), "cut"),
        ),
        (Collider("box", (0.045, 0.105, 0.038), (0, 0, 0.0127)),),
    )
