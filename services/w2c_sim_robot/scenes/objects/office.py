"""What lies on a desk."""

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
    cylinder_collider,
    fitted,
    merged,
)
from w2c_sim_robot.scenes.objects.solids import rod, slab

DARK = (0.12, 0.12, 0.13)
STEEL = (0.70, 0.71, 0.73)


def laptop(size: Size, rng: np.random.Generator) -> Shape:
    """Return an open laptop that shows its screen to the robot."""
    x, y, thick = 0.23, 0.33, 0.016
    base = slab(x, y, thick, 0.012, 0.003)
    keys = box((0.42 * x, 0.86 * y, 4e-4), ("+z",)).moved((0.17 * x, 0, thick))
    pad = box((0.25 * x, 0.32 * y, 4e-4), ("+z",)).moved((-0.28 * x, 0, thick))
    tilt = np.radians(18.0)
    turn = np.array([[np.cos(tilt), 0, np.sin(tilt)], [0, 1, 0], [-np.sin(tilt), 0, np.cos(tilt)]])
    lid = box((0.008, y, 0.21)).rotated(turn).moved((x / 2, 0, thick))
    glass = box((4e-4, 0.94 * y, 0.19), ("-x",)).moved((-0.0044, 0, 0.011)).rotated(turn)
    picture = np.zeros((120, 200, 3), np.uint8)
    picture[:] = (38, 70, 120)
    picture[8:100, 20:180] = (236, 238, 240)
    picture[8:18, 20:180] = (120, 150, 190)
    for line in range(26, 94, 8):
        picture[line : line + 3, 30 : int(rng.integers(90, 170))] = (90, 90, 96)
    body = Surface("main", textures.brushed(rng), 0.7)
    return fitted(
        size,
        (
            Part(base, body),
            Part(lid, body, "lid"),
            Part(keys, Surface((0.25, 0.25, 0.27), textures.grid(5, 14), 0.2), "keyboard"),
            Part(pad, Surface((0.45, 0.46, 0.48), None, 0.3)),
            Part(glass.moved((x / 2, 0, thick)), Surface((1.0, 1.0, 1.0), picture, 0.4), "screen"),
        ),
        (
            Collider("box", (x / 2, y / 2, thick / 2), (0, 0, thick / 2)),
            Collider("box", (0.032, y / 2, 0.1), (x / 2 + 0.032, 0, thick + 0.1)),
        ),
    )


def keyboard(size: Size, rng: np.random.Generator) -> Shape:
    """Return a keyboard; its keys away from the robot are the function keys."""
    x, y, z = size
    keys = box((0.86 * x, 0.95 * y, 4e-4), ("+z",)).moved((0, 0, z))
    return Shape(
        (
            Part(slab(x, y, z, 0.008, 0.003), Surface("main", textures.speckle(rng, 0.01), 0.3)),
            Part(keys, Surface("accent", textures.grid(6, 20, ink=0.35), 0.2), "keys"),
        ),
        (box_collider(size),),
    )


def stapler(size: Size, _rng: np.random.Generator) -> Shape:
    """Return a stapler that points to the left."""
    base = slab(0.034, 0.14, 0.01, 0.012, 0.003)
    tilt = np.radians(7.0)
    turn = np.array([[1, 0, 0], [0, np.cos(tilt), -np.sin(tilt)], [0, np.sin(tilt), np.cos(tilt)]])
    arm = slab(0.03, 0.13, 0.02, 0.012, 0.006).rotated(turn).moved((0, 0.0, 0.03))
    rail = slab(0.02, 0.125, 0.008, 0.004, 0.001).rotated(turn).moved((0, 0, 0.02))
    hinge = slab(0.032, 0.03, 0.03, 0.008, 0.003).moved((0, -0.05, 0.006))
    return fitted(
        size,
        (
            Part(merged(base, hinge), Surface(DARK, None, 0.4), "base"),
            Part(arm, Surface("main", None, 0.7), "arm"),
            Part(rail, Surface(STEEL, None, 1.0), "rail", "metal"),
        ),
        (Collider("box", (0.017, 0.07, 0.026), (0, 0, 0.026)),),
    )


def lamp(size: Size, rng: np.random.Generator) -> Shape:
    """Return a desk lamp: a heavy foot, a bent arm, a shade."""
    paint = textures.brushed(rng)
    foot = lathe([[0, 0], [0.085, 0], [0.085, 0.012], [0.07, 0.022], [0, 0.024]])
    pole = tube([[0.0, 0, 0.02], [0.0, 0, 0.25], [-0.03, 0, 0.33], [-0.1, 0, 0.37]], 0.007)
    shade = merged(
        lathe([[0.088, 0], [0.09, 0.0], [0.04, 0.1], [0.025, 0.11], [0, 0.11]]),
        lathe([[0.025, 0.105], [0.038, 0.095], [0.088, 0.0]]),
    )
    bulb = lathe([[0, 0.02], [0.03, 0.02], [0.03, 0.05], [0, 0.06]])
    tilt = np.radians(-20.0)
    turn = np.array([[np.cos(tilt), 0, np.sin(tilt)], [0, 1, 0], [-np.sin(tilt), 0, np.cos(tilt)]])
    return fitted(
        size,
        (
            Part(foot, Surface("main", paint, 0.7), "base"),
            Part(pole, Surface(STEEL, None, 1.0), "arm", "metal"),
            Part(shade.rotated(turn).moved((-0.13, 0, 0.28)), Surface("main", paint, 0.7), "shade"),
            Part(bulb.rotated(turn).moved((-0.13, 0, 0.28)), Surface((1.0, 0.97, 0.82), None, 0.2)),
        ),
        (
            Collider("cylinder", (0.085, 0.04), (0, 0, 0.04)),
            Collider("box", (0.01, 0.01, 0.15), (0, 0, 0.21)),
            Collider("box", (0.05, 0.05, 0.04), (-0.12, 0, 0.33)),
        ),
    )


def pen_holder(size: Size, rng: np.random.Generator) -> Shape:
    """Return a cup full of pencils."""
    r, z = 0.042, 0.1
    outer = lathe([[0, 0], [0.96 * r, 0], [r, 0.05 * z], [r, z]])
    inner = lathe([[r, z], [0.9 * r, z], [0.88 * r, 0.06 * z], [0, 0.06 * z]])
    parts = [
        Part(outer, Surface("main", textures.rings(rng, bands=1), 0.5)),
        Part(inner, Surface("main", None, 0.3)),
    ]
    colours = [
        (0.95, 0.75, 0.1),
        (0.8, 0.1, 0.1),
        (0.1, 0.3, 0.7),
        (0.1, 0.5, 0.2),
        (0.1, 0.1, 0.1),
    ]
    for number, colour in enumerate(colours):
        angle = 2 * np.pi * (number + 0.3 * rng.random()) / len(colours)
        out = np.array([np.cos(angle), np.sin(angle)])
        top = 0.155 + 0.02 * rng.random()
        foot, tip = 0.35 * r * -out, 0.85 * r * out
        line = [[*foot, 0.008], [*tip, top]]
        point = [[*tip, top], [*(tip + 0.1 * (tip - foot)), top + 0.013]]
        parts.append(Part(rod(line, 0.0038, 8), Surface(colour, None, 0.4), "pencil"))
        parts.append(
            Part(
                rod(point, np.array([0.0038, 0.0006]), 8),
                Surface((0.85, 0.7, 0.5), None, 0.1),
                "pencil",
            )
        )
    return fitted(
        size,
        tuple(parts),
        (
            Collider("cylinder", (r, z / 2), (0, 0, z / 2)),
            Collider("cylinder", (0.6 * r, 0.04), (0, 0, z + 0.04)),
        ),
    )


def binder(size: Size, rng: np.random.Generator) -> Shape:
    """Return a ring binder that lies flat, its labelled back to the left."""
    x, y, z = size
    board = 0.003
    lower, upper = slab(x, y, board, 0.004), slab(x, y, board, 0.004).moved((0, 0, z - board))
    back = box((x, board, z - 2 * board)).moved((0, y / 2 - board / 2, board))
    sheets = box((0.93 * x, 0.9 * y, 0.7 * (z - 2 * board)), ("+x", "-x", "-y", "+z")).moved(
        (0, -0.02 * y, board)
    )
    label = box((0.5 * x, 4e-4, 0.7 * z), ("+y",)).moved((0, y / 2 + 2e-4, 0.15 * z))
    sticker = prism(rounded_rectangle(0.2 * x, 0.5 * y, 0.004), 3e-4).moved((0.2 * x, 0, z))
    ring = lathe([[0.009, 0], [0.012, 0], [0.012, 4e-4], [0.009, 4e-4]]).moved(
        (-0.36 * x, 0.36 * y, z - 1e-4)
    )
    return Shape(
        (
            Part(merged(lower, upper, back), Surface("main", textures.speckle(rng, 0.015), 0.35)),
            Part(sheets, Surface((0.95, 0.94, 0.9), textures.pages(rng), 0.05), "pages", "paper"),
            Part(
                merged(label, sticker),
                Surface((0.97, 0.96, 0.92), textures.lines(rng, 96, 160, 24), 0.1),
                "label",
            ),
            Part(ring, Surface(STEEL, None, 1.0)),
        ),
        (box_collider(size),),
    )


def magazine(size: Size, rng: np.random.Generator) -> Shape:
    """Return a glossy magazine with a title over a picture."""
    x, y, z = size
    title = textures.words(
        (("STYLE", "HOME", "SPORT", "NATURE")[int(rng.integers(4))],),
        (288, 96),
        ink=(0.1, 0.1, 0.1),
        ground=(0.96, 0.96, 0.96),
    )
    hills = np.full((300, 288, 3), (205, 220, 235), np.uint8)
    across = np.arange(288)
    for shade, level in (((120, 150, 130), 90), ((80, 115, 85), 150), ((50, 75, 55), 210)):
        ridge = level + 28 * np.sin(across / rng.uniform(25, 60) + rng.uniform(0, 6))
        hills[np.arange(300)[:, None] > ridge[None, :]] = shade
    cover = np.vstack([title, hills])
    pages = slab(0.99 * x, 0.99 * y, 0.96 * z, 0.002, 0.0001)
    face = box((x, y, z), ("+z",))
    return Shape(
        (
            Part(pages, Surface((0.95, 0.94, 0.92), textures.pages(rng), 0.3), "pages", "paper"),
            Part(face, Surface("main", cover, 0.7), "cover"),
        ),
        (box_collider(size),),
    )


def soap_dispenser(size: Size, rng: np.random.Generator) -> Shape:
    """Return a bottle of soap with a pump that points to the robot."""
    r, z = 0.034, 0.13
    body = lathe(
        [[0, 0], [0.95 * r, 0], [r, 0.04 * z], [r, 0.78 * z], [0.8 * r, 0.92 * z], [0.4 * r, z]]
    )
    pump = merged(
        lathe([[0.42 * r, 0.96 * z], [0.42 * r, 1.12 * z], [0.15 * r, 1.12 * z]]),
        lathe(
            [[0.15 * r, 1.1 * z], [0.15 * r, 1.28 * z], [0.3 * r, 1.28 * z], [0.3 * r, 1.36 * z]]
        ),
        lathe([[0.3 * r, 1.36 * z], [0, 1.38 * z]]),
        rod([[0, 0, 1.32 * z], [-1.1 * r, 0, 1.32 * z], [-1.25 * r, 0, 1.26 * z]], 0.005),
    )
    label = lathe([[1.012 * r, 0.2 * z], [1.012 * r, 0.66 * z]])
    return fitted(
        size,
        (
            Part(body, Surface("main", None, 0.8)),
            Part(pump, Surface((0.94, 0.94, 0.93), None, 0.5), "pump"),
            Part(label, Surface((0.96, 0.95, 0.92), textures.label(rng), 0.2), "label"),
        ),
        (
            Collider("cylinder", (r, 0.5 * z), (0, 0, 0.5 * z)),
            Collider("cylinder", (0.5 * r, 0.19 * z), (0, 0, 1.19 * z)),
        ),
    )


def toilet_paper(size: Size, rng: np.random.Generator) -> Shape:
    """Return a roll of toilet paper that stands upright."""
    r, z = size[1] / 2, size[2]
    roll = lathe([[0.38 * r, 0], [0.97 * r, 0], [r, 0.03 * z], [r, 0.97 * z], [0.97 * r, z]])
    top = lathe([[0.97 * r, z], [0.38 * r, z]])
    core = lathe([[0.38 * r, z], [0.38 * r, 0]])
    return Shape(
        (
            Part(merged(roll, top), Surface("main", textures.speckle(rng, 0.02, 8), 0.0)),
            Part(core, Surface((0.72, 0.60, 0.44), None, 0.05), "core", "cardboard"),
        ),
        (cylinder_collider(size),),
    )


def hairbrush(size: Size, rng: np.random.Generator) -> Shape:
    """Return a hairbrush that lies on its back, its handle towards the robot."""
    handle = slab(0.13, 0.024, 0.014, 0.011, 0.004).moved((-0.075, 0, 0))
    back = slab(0.11, 0.064, 0.014, 0.028, 0.004).moved((0.04, 0, 0))
    pad = slab(0.095, 0.05, 0.006, 0.022, 0.002).moved((0.04, 0, 0.013))
    bristles = [
        rod([[0.04 + a, b, 0.018], [0.04 + a, b, 0.034]], 0.0016, 6)
        for a in np.linspace(-0.036, 0.036, 8)
        for b in np.linspace(-0.016, 0.016, 4)
    ]
    return fitted(
        size,
        (
            Part(handle, Surface("main", textures.wood(rng, 64, 64, 1), 0.4), "handle"),
            Part(back, Surface("main", textures.wood(rng, 64, 64, 1), 0.4)),
            Part(merged(pad, *bristles), Surface(DARK, None, 0.3), "bristles"),
        ),
        (
            Collider("box", (0.065, 0.012, 0.007), (-0.075, 0, 0.007)),
            Collider("box", (0.055, 0.032, 0.017), (0.04, 0, 0.017)),
        ),
    )
