"""What stands about on a building site or in a plant."""

import numpy as np

from w2c_sim_robot.scenes.objects import textures
from w2c_sim_robot.scenes.objects.meshes import arc, lathe, prism, rounded_rectangle, tube
from w2c_sim_robot.scenes.objects.shape import (
    Collider,
    Part,
    Shape,
    Size,
    Surface,
    fitted,
    merged,
)
from w2c_sim_robot.scenes.objects.solids import (
    about_z,
    ellipsoid,
    flat_ring,
    rod,
    slab,
    turned,
    wall_colliders,
)

STEEL = (0.62, 0.63, 0.65)
RUBBER = (0.10, 0.10, 0.11)


def helmet(size: Size, _rng: np.random.Generator) -> Shape:
    """Return a builder's helmet with a peak towards the robot and three ribs."""
    shell = ellipsoid((0.14, 0.11, 0.14), 0, 90)
    brim = slab(0.3, 0.235, 0.008, 0.11, 0.002)
    peak = slab(0.08, 0.17, 0.008, 0.04, 0.002).moved((-0.155, 0, 0.0))
    ribs = []
    for place in (-0.035, 0.0, 0.035):
        angle = np.linspace(0.2, np.pi - 0.2, 20)
        rise = np.sqrt(1.0 - (place / 0.11) ** 2)
        path = np.column_stack(
            [0.14 * rise * np.cos(angle), np.full(20, place), 0.14 * rise * np.sin(angle)]
        )
        ribs.append(rod(path, 0.006, 8))
    plastic = Surface("main", None, 0.6)
    return fitted(
        size,
        (
            Part(merged(shell, brim), plastic),
            Part(merged(*ribs), plastic, "rib"),
            Part(peak, plastic, "peak"),
        ),
        (
            Collider("box", (0.15, 0.117, 0.004), (0, 0, 0.004)),
            Collider("cylinder", (0.09, 0.06), (0, 0, 0.06)),
        ),
    )


def cone(size: Size, rng: np.random.Generator) -> Shape:
    """Return a traffic cone with two white bands."""
    x, _, z = size
    foot = slab(x, size[1], 0.06 * z, 0.03, 0.004)
    r, top = 0.4 * x, 0.1 * x

    def at(share: float) -> list[float]:
        return [r + (top - r) * share, z * (0.06 + 0.94 * share)]

    bands = [(0.0, 0.35), (0.55, 0.7), (0.86, 1.0)]
    body = merged(*(lathe([at(low), at(high)]) for low, high in bands), lathe([at(1.0), [0, z]]))
    white = merged(lathe([at(0.35), at(0.55)]), lathe([at(0.7), at(0.86)]))
    return Shape(
        (
            Part(merged(foot, body), Surface("main", textures.speckle(rng, 0.01), 0.4)),
            Part(white, Surface((0.95, 0.95, 0.94), None, 0.5), "band"),
        ),
        (
            Collider("box", (x / 2, size[1] / 2, 0.03 * z), (0, 0, 0.03 * z)),
            Collider("cylinder", (0.25 * x, 0.47 * z), (0, 0, 0.53 * z)),
        ),
    )


def pipe(size: Size, rng: np.random.Generator) -> Shape:
    """Return a piece of pipe with flanges that lies along y."""
    _, y, z = size
    r = z / 2
    profile = [[0.6 * r, -y / 2], [r, -y / 2], [r, -y / 2 + 0.02], [0.72 * r, -y / 2 + 0.02]]
    profile += [[0.72 * r, y / 2 - 0.02], [r, y / 2 - 0.02], [r, y / 2], [0.6 * r, y / 2]]
    inside = [[0.6 * r, y / 2], [0.6 * r, -y / 2]]
    outer = turned(profile, "y").moved((0, 0, r))
    return Shape(
        (
            Part(outer, Surface("main", textures.brushed(rng), 0.7)),
            Part(turned(inside, "y").moved((0, 0, r)), Surface((0.12, 0.12, 0.13), None, 0.1)),
        ),
        (Collider("box", (r, y / 2, r), (0, 0, r)),),
    )


def gearwheel(size: Size, rng: np.random.Generator) -> Shape:
    """Return a gearwheel that lies flat, with a hub."""
    r, z = size[1] / 2, size[2]
    disc = flat_ring(0.88 * r, 0.2 * r, 0.8 * z)
    hub = flat_ring(0.38 * r, 0.2 * r, z)
    count = 16
    teeth = []
    for number in range(count):
        angle = 2 * np.pi * number / count
        outline = np.array(
            [
                [-0.09 * r, -0.09 * r],
                [0.13 * r, -0.055 * r],
                [0.13 * r, 0.055 * r],
                [-0.09 * r, 0.09 * r],
            ]
        )
        tooth = prism(outline, 0.8 * z).rotated(about_z(angle))
        teeth.append(
            tooth.moved((0.87 * r * float(np.cos(angle)), 0.87 * r * float(np.sin(angle)), 0))
        )
    steel = textures.brushed(rng)
    return Shape(
        (
            Part(merged(disc, *teeth), Surface("main", steel, 0.9)),
            Part(hub, Surface("main", steel, 0.9), "hub"),
        ),
        (
            Collider("cylinder", (0.94 * r, 0.4 * z), (0, 0, 0.4 * z)),
            Collider("cylinder", (0.38 * r, 0.5 * z), (0, 0, 0.5 * z)),
        ),
    )


def canister(size: Size, rng: np.random.Generator) -> Shape:
    """Return a fuel canister with a handle on top and a spout with a cap."""
    x, y, z = size
    body = prism(rounded_rectangle(x, y, 0.03), 0.82 * z, 0.015)
    panel = [
        rod([[s * (x / 2 - 0.001), -0.3 * y, a * z], [s * (x / 2 - 0.001), 0.3 * y, b * z]], 0.004)
        for s in (-1, 1)
        for a, b in ((0.15, 0.65), (0.65, 0.15))
    ]
    grip = [[0, -0.3 * y, 0.8 * z], [0, -0.28 * y, 0.95 * z], [0, 0.1 * y, 0.95 * z]]
    grip += [[0, 0.13 * y, 0.8 * z]]
    spout = lathe([[0.032, 0.8 * z], [0.026, 0.9 * z], [0.026, 0.92 * z]]).moved((0, 0.33 * y, 0))
    cap = lathe([[0.034, 0.9 * z], [0.034, z], [0, z]]).moved((0, 0.33 * y, 0))
    paint = textures.speckle(rng, 0.012)
    return Shape(
        (
            Part(merged(body, *panel, spout), Surface("main", paint, 0.45)),
            Part(rod(grip, 0.05 * z), Surface("main", paint, 0.45), "handle"),
            Part(cap, Surface(RUBBER, None, 0.4), "cap"),
        ),
        (
            Collider("box", (x / 2, y / 2, 0.41 * z), (0, 0, 0.41 * z)),
            Collider("box", (0.015, 0.2 * y, 0.09 * z), (0, -0.1 * y, 0.91 * z)),
            Collider("cylinder", (0.034, 0.09 * z), (0, 0.33 * y, 0.91 * z)),
        ),
    )


def bucket(size: Size, rng: np.random.Generator) -> Shape:
    """Return a pail with a hoop that is folded to one side."""
    r, z = size[1] / 2, size[2]
    outer = lathe([[0, 0], [0.74 * r, 0], [0.94 * r, 0.96 * z], [r, 0.965 * z], [r, z]])
    inner = lathe([[r, z], [0.92 * r, z], [0.71 * r, 0.03 * z], [0, 0.03 * z]])
    hoop = arc((0, 0, 0), (0.97 * r, 0.93 * r), 0.0, np.pi, 24)
    lying = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])
    bail = tube((hoop @ lying.T) * [-1.0, 1.0, 1.0], 0.004, 8).moved((0, 0, z))
    return Shape(
        (
            Part(outer, Surface("main", textures.speckle(rng, 0.01), 0.5)),
            Part(inner, Surface("main", None, 0.3)),
            Part(bail, Surface(STEEL, None, 0.9), "handle", "metal"),
        ),
        (
            Collider("cylinder", (0.74 * r, 0.02 * z), (0, 0, 0.02 * z)),
            *wall_colliders((1.3 * r, 1.3 * r, 0.98 * z), 0.01),
        ),
    )
