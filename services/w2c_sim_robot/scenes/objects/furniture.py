"""What things stand on."""

import numpy as np

from w2c_sim_robot.scenes.objects import textures
from w2c_sim_robot.scenes.objects.meshes import box, prism, rounded_rectangle
from w2c_sim_robot.scenes.objects.shape import Collider, Part, Shape, Size, Surface, merged

TOP = 0.035
"""Thickness of a table top [m]"""


def table(size: Size, rng: np.random.Generator) -> Shape:
    """Return a table on four legs; the grain of its top runs along y."""
    x, y, z = size
    top = prism(rounded_rectangle(x, y, 0.02), TOP, 0.003).moved((0, 0, z - TOP))
    inset, thick = 0.09, 0.055
    places = [(a * (x / 2 - inset), b * (y / 2 - inset)) for a in (-1, 1) for b in (-1, 1)]
    legs = [box((thick, thick, z - TOP)).moved((px, py, 0)) for px, py in places]
    apron = [
        box((0.02, y - 2 * inset, 0.07)).moved((s * (x / 2 - inset), 0, z - TOP - 0.07))
        for s in (-1, 1)
    ]
    half_leg = (thick / 2, thick / 2, (z - TOP) / 2)
    return Shape(
        (
            Part(top, Surface("main", textures.wood(rng, 1024, 1024, 6), 0.3), "top"),
            Part(merged(*legs, *apron), Surface("main", None, 0.2)),
        ),
        (
            Collider("box", (x / 2, y / 2, TOP / 2), (0, 0, z - TOP / 2)),
            *(Collider("box", half_leg, (px, py, (z - TOP) / 2)) for px, py in places),
        ),
    )


def counter(size: Size, rng: np.random.Generator) -> Shape:
    """Return a closed cupboard with a worktop that overhangs its doors."""
    x, y, z = size
    worktop = prism(rounded_rectangle(x, y, 0.012), 0.04, 0.004).moved((0, 0, z - 0.04))
    body = box((x - 0.06, y - 0.02, z - 0.14)).moved((0.02, 0, 0.1))
    plinth = box((x - 0.16, y - 0.06, 0.1)).moved((0.04, 0, 0))
    doors, knobs = [], []
    count = max(2, round(y / 0.5))
    wide = (y - 0.02) / count
    for number in range(count):
        middle = -(y - 0.02) / 2 + (number + 0.5) * wide
        doors.append(box((0.018, wide - 0.006, z - 0.16)).moved((-x / 2 + 0.041, middle, 0.11)))
        knobs.append(
            box((0.02, 0.012, 0.12)).moved((-x / 2 + 0.024, middle + 0.4 * wide, z - 0.32))
        )
    return Shape(
        (
            Part(worktop, Surface("main", textures.concrete(rng), 0.5), "worktop"),
            Part(merged(body, *doors), Surface((0.86, 0.86, 0.84), None, 0.25)),
            Part(merged(plinth, *knobs), Surface((0.35, 0.36, 0.38), None, 0.8)),
        ),
        (Collider("box", (x / 2, y / 2, z / 2), (0, 0, z / 2)),),
    )
