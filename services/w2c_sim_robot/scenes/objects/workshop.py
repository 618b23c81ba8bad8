"""Hand tools and what lies about on a workbench."""

import numpy as np

from w2c_sim_robot.scenes.objects import textures
from w2c_sim_robot.scenes.objects.meshes import box, lathe
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
from w2c_sim_robot.scenes.objects.solids import (
    about_z,
    flat_ring,
    open_wall,
    rod,
    slab,
    turned,
)

STEEL = (0.62, 0.63, 0.65)
DARK_STEEL = (0.33, 0.34, 0.36)
RUBBER = (0.10, 0.10, 0.11)


def hammer(size: Size, rng: np.random.Generator) -> Shape:
    """Return a claw hammer that lies on its side, its handle towards the robot."""
    face = turned(
        [[0, 0], [0.014, 0], [0.014, 0.012], [0.010, 0.02], [0.010, 0.05], [0, 0.05]], "y"
    )
    head = merged(
        face.moved((0.14, -0.062, 0)),
        box((0.024, 0.026, 0.022)).moved((0.14, 0.0, -0.011)),
        rod([[0.145, 0.012, 0], [0.144, 0.04, 0], [0.130, 0.066, 0]], 0.008),
        rod([[0.135, 0.012, 0], [0.132, 0.04, 0], [0.116, 0.064, 0]], 0.006),
    )
    along = np.linspace(-0.15, 0.135, 12)
    thick = np.interp(
        along, [-0.15, -0.13, -0.05, 0.05, 0.135], [0.011, 0.014, 0.012, 0.009, 0.010]
    )
    handle = rod(np.column_stack([along, 0 * along, 0 * along]), thick, 14, 0.8)
    return fitted(
        size,
        (
            Part(head, Surface(DARK_STEEL, textures.brushed(rng), 0.9), "head", "metal"),
            Part(handle, Surface("main", textures.wood(rng, 128, 128, 1), 0.3), "handle"),
        ),
        (
            Collider("box", (0.016, 0.062, 0.014), (0.14, 0.002, 0)),
            Collider("box", (0.14, 0.012, 0.014), (-0.01, 0, 0)),
        ),
    )


def screwdriver(size: Size, _rng: np.random.Generator) -> Shape:
    """Return a screwdriver that lies flat, its grip towards the robot."""
    grip = turned(
        [
            [0, -0.11],
            [0.010, -0.108],
            [0.014, -0.09],
            [0.014, -0.04],
            [0.009, -0.02],
            [0.012, -0.008],
            [0, -0.004],
        ],
        "x",
    )
    shaft = turned([[0.0032, -0.01], [0.0032, 0.1], [0.0012, 0.112], [0, 0.112]], "x")
    return fitted(
        size,
        (
            Part(grip, Surface("main", None, 0.7), "handle"),
            Part(shaft, Surface(STEEL, None, 1.0), "shaft", "metal"),
        ),
        (
            Collider("box", (0.053, 0.013, 0.014), (-0.057, 0, 0)),
            Collider("box", (0.06, 0.004, 0.009), (0.055, 0, -0.005)),
        ),
    )


def wrench(size: Size, rng: np.random.Generator) -> Shape:
    """Return a ring and open-end wrench that lies flat along x."""
    x, y, z = 0.22, 0.046, 0.012
    shaft = slab(0.17, 0.016, 0.6 * z, 0.006, 0.0015).moved((0, 0, 0.2 * z))
    ring = flat_ring(0.014, 0.0085, z).moved((-x / 2 + 0.014, 0, 0))
    jaw = [
        slab(0.036, 0.014, z, 0.006, 0.0015)
        .rotated(about_z(side * 0.25))
        .moved((x / 2 - 0.018, side * 0.0155, 0))
        for side in (-1, 1)
    ]
    throat = slab(0.022, y, z, 0.01, 0.0015).moved((x / 2 - 0.04, 0, 0))
    return fitted(
        size,
        (Part(merged(shaft, ring, throat, *jaw), Surface("main", textures.brushed(rng), 1.0)),),
        (
            Collider("box", (0.075, 0.008, z / 2), (0, 0, z / 2)),
            Collider("box", (0.026, y / 2, z / 2), (x / 2 - 0.026, 0, z / 2)),
            Collider("box", (0.014, 0.014, z / 2), (-x / 2 + 0.014, 0, z / 2)),
        ),
    )


def nail_box(size: Size, rng: np.random.Generator) -> Shape:
    """Return an open box full of nails, with a printed front.

    Full to the rim: a hand that comes to what is seen must not meet the solid box before.
    """
    x, y, z = size
    card = Surface("main", textures.cardboard(rng), 0.08)
    sign = textures.words(("NAILS", "4 x 100"), (256, 128), ground=(0.95, 0.93, 0.86))
    label = box((4e-4, 0.7 * y, 0.62 * z), ("-x",)).moved((-x / 2 - 2e-4, 0, 0.19 * z))
    floor = slab(0.99 * x, 0.99 * y, 0.05 * z, 0.003, 0.0002)
    nails = []
    for _ in range(46):
        turn = rng.normal(0.0, 0.5) + (np.pi if rng.random() < 0.5 else 0.0)
        middle = np.array(
            [
                rng.uniform(-0.27, 0.27) * x,
                rng.uniform(-0.3, 0.3) * y,
                rng.uniform(0.9, 0.97) * z,
            ]
        )
        along = np.array([np.sin(turn), np.cos(turn), rng.normal(0.0, 0.04)])
        half = 0.17 * min(x, y) * 1.3
        nails.append(
            rod([middle - half * along, middle + half * along], np.array([0.0022, 0.0018]), 6)
        )
        nails.append(rod([middle - half * along, middle - (half - 0.0015) * along], 0.0055, 8))
    heap = slab(0.94 * x, 0.94 * y, 0.87 * z, 0.003, 0.001).moved((0, 0, 0.05 * z))
    return Shape(
        (
            Part(merged(open_wall(x, y, z, 0.004, 0.004), floor), card),
            Part(label, Surface((1.0, 1.0, 1.0), sign, 0.2), "label"),
            Part(heap, Surface((0.24, 0.25, 0.27), textures.speckle(rng, 0.2, 3), 0.6)),
            Part(merged(*nails), Surface((0.66, 0.67, 0.70), None, 1.0), "nails", "metal"),
        ),
        (box_collider(size),),
    )


def drill(size: Size, rng: np.random.Generator) -> Shape:
    """Return a cordless drill that lies on its side, the chuck to the left."""
    barrel = turned(
        [[0, -0.075], [0.022, -0.075], [0.028, -0.06], [0.028, 0.045], [0.02, 0.055], [0, 0.055]],
        "y",
    )
    chuck = turned([[0.017, 0.055], [0.017, 0.085], [0.009, 0.1], [0, 0.1]], "y")
    bit = turned([[0.003, 0.1], [0.003, 0.145], [0, 0.15]], "y")
    grip = slab(0.115, 0.042, 0.036, 0.014, 0.006).moved((-0.075, -0.03, -0.018))
    battery = slab(0.045, 0.095, 0.056, 0.01, 0.005).moved((-0.148, -0.02, -0.028))
    trigger = slab(0.03, 0.012, 0.018, 0.004, 0.002).moved((-0.045, -0.004, -0.009))
    return fitted(
        size,
        (
            Part(merged(barrel, grip), Surface("main", textures.speckle(rng, 0.01), 0.4), "handle"),
            Part(merged(battery, trigger), Surface(RUBBER, None, 0.3), "battery"),
            Part(merged(chuck, bit), Surface(STEEL, None, 1.0), "chuck", "metal"),
        ),
        (
            Collider("box", (0.028, 0.065, 0.028), (0, -0.01, 0)),
            Collider("box", (0.0575, 0.021, 0.024), (-0.075, -0.03, -0.004)),
            Collider("box", (0.0225, 0.0475, 0.028), (-0.148, -0.02, 0)),
        ),
    )


def tape(size: Size, rng: np.random.Generator) -> Shape:
    """Return a roll of adhesive tape that lies flat."""
    r, z = size[1] / 2, size[2]
    roll = merged(
        lathe([[0.6 * r, 0], [r, 0], [r, z], [0.6 * r, z]]),
    )
    core = lathe([[0.6 * r, z], [0.55 * r, z], [0.55 * r, 0], [0.6 * r, 0]])
    return Shape(
        (
            Part(roll, Surface("main", textures.rings(rng, bands=0), 0.6)),
            Part(core, Surface((0.75, 0.62, 0.42), None, 0.1), "core", "cardboard"),
        ),
        (cylinder_collider(size),),
    )
