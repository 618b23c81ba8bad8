"""Things to wear."""

import numpy as np

from w2c_sim_robot.scenes.objects import textures
from w2c_sim_robot.scenes.objects.meshes import lathe, prism, strips
from w2c_sim_robot.scenes.objects.shape import (
    Collider,
    Mesh,
    Part,
    Points,
    Shape,
    Size,
    Surface,
    fitted,
    merged,
)
from w2c_sim_robot.scenes.objects.solids import ellipsoid, polygon, rod, slab


def shirt(size: Size, rng: np.random.Generator) -> Shape:
    """Return a folded shirt, its collar away from the robot."""
    layers = [
        slab(0.32, 0.25, 0.018, 0.02, 0.006),
        slab(0.31, 0.243, 0.018, 0.02, 0.006).moved((-0.004, 0, 0.017)),
    ]
    collar = [
        rod([[0.07, 0, 0.036], [0.14, s * 0.05, 0.038], [0.155, s * 0.02, 0.039]], 0.008, 10, 2.0)
        for s in (-1, 1)
    ]
    placket = slab(0.22, 0.022, 0.002, 0.004, 0.0005).moved((-0.04, 0, 0.035))
    buttons = [
        lathe([[0, 0], [0.006, 0], [0.006, 0.002], [0, 0.0025]]).moved((place, 0, 0.036))
        for place in (-0.12, -0.06, 0.0, 0.05)
    ]
    fabric = textures.weave(rng) if rng.random() < 0.5 else textures.stripes(rng, 12)
    return fitted(
        size,
        (
            Part(merged(*layers, placket), Surface("main", fabric, 0.02)),
            Part(merged(*collar), Surface("main", fabric, 0.02), "collar"),
            Part(merged(*buttons), Surface("accent", None, 0.5), "button"),
        ),
        (Collider("box", (0.16, 0.125, 0.017), (0, 0, 0.017)),),
    )


def hat(size: Size, rng: np.random.Generator) -> Shape:
    """Return a hat with a brim and a band."""
    r, z = size[1] / 2, size[2]
    brim = merged(
        lathe([[0, 0], [0.96 * r, 0.05 * z], [r, 0.08 * z]]),
        lathe([[r, 0.08 * z], [0.96 * r, 0.1 * z], [0.6 * r, 0.06 * z]]),
    )
    crown = lathe(
        [
            [0.58 * r, 0.05 * z],
            [0.55 * r, 0.5 * z],
            [0.5 * r, 0.85 * z],
            [0.42 * r, z],
            [0.2 * r, 0.99 * z],
            [0, 0.93 * z],
        ]
    )
    band = lathe([[0.592 * r, 0.06 * z], [0.575 * r, 0.3 * z]])
    straw = textures.weave(rng, 128)
    return Shape(
        (
            Part(brim, Surface("main", straw, 0.02), "brim"),
            Part(crown, Surface("main", straw, 0.02)),
            Part(band, Surface("accent", None, 0.1), "band"),
        ),
        (
            Collider("cylinder", (0.9 * r, 0.04 * z), (0, 0, 0.04 * z)),
            Collider("cylinder", (0.5 * r, 0.46 * z), (0, 0, 0.52 * z)),
        ),
    )


def shoe(size: Size, rng: np.random.Generator) -> Shape:
    """Return a trainer with a pale sole, its toe away from the robot."""
    outline = np.array(
        [
            [0.15, 0.0],
            [0.145, 0.025],
            [0.12, 0.043],
            [0.06, 0.048],
            [-0.02, 0.038],
            [-0.1, 0.036],
            [-0.135, 0.025],
            [-0.145, 0.0],
            [-0.135, -0.025],
            [-0.1, -0.036],
            [-0.02, -0.038],
            [0.06, -0.046],
            [0.12, -0.04],
            [0.145, -0.022],
        ]
    )
    sole = prism(outline, 0.028, 0.003)
    stations = np.array(
        [
            # along, half width, height of the upper there
            [0.138, 0.022, 0.045],
            [0.10, 0.038, 0.06],
            [0.05, 0.040, 0.08],
            [0.0, 0.036, 0.105],
            [-0.04, 0.033, 0.118],
            [-0.09, 0.032, 0.122],
            [-0.128, 0.027, 0.125],
        ]
    )
    toe = ellipsoid((0.055, 0.037, 0.045), 0, 90).moved((0.085, -0.001, 0.026))
    heel = _shell(stations[2:])
    mouth = polygon(
        np.column_stack(
            [
                np.array([-0.01, -0.03, -0.09, -0.12, -0.12, -0.09, -0.03, -0.01]),
                np.array([0.0, 0.024, 0.022, 0.014, -0.014, -0.022, -0.024, 0.0]) * 1.05,
                np.full(8, 0.1265),
            ]
        )[[0, 1, 2, 3, 4, 5, 6]]
    )
    laces = [
        rod(
            [
                [place, -0.022, 0.068 + rise],
                [place + 0.004, 0, 0.076 + rise],
                [place, 0.022, 0.068 + rise],
            ],
            0.0035,
            8,
        )
        for place, rise in ((0.075, 0.003), (0.055, 0.009), (0.035, 0.018), (0.015, 0.027))
    ]
    return fitted(
        size,
        (
            Part(merged(toe, heel), Surface("main", textures.weave(rng, 128), 0.15)),
            Part(sole, Surface((0.93, 0.92, 0.88), None, 0.2), "sole", "rubber"),
            Part(merged(*laces), Surface((0.96, 0.96, 0.95), None, 0.05), "laces"),
            Part(mouth, Surface((0.10, 0.10, 0.11), None, 0.0)),
        ),
        (
            Collider("box", (0.145, 0.04, 0.03), (0, 0, 0.03)),
            Collider("box", (0.07, 0.033, 0.03), (-0.06, 0, 0.09)),
        ),
    )


def _shell(stations: Points) -> Mesh:
    """Return the upper of a shoe: arches from side to side at each (along, half width, height)."""
    angle = np.linspace(0.0, np.pi, 15)
    rows, normals, texcoords = [], [], []
    for number, (along, wide, high) in enumerate(stations):
        across = wide * np.sign(np.cos(angle)) * np.abs(np.cos(angle)) ** 0.6
        up = 0.026 + (high - 0.026) * np.sin(angle) ** 0.5
        rows.append(np.column_stack([np.full(15, along), across, up]))
        normal = np.column_stack([np.full(15, 0.25), np.cos(angle), np.sin(angle)])
        normals.append(normal / np.linalg.norm(normal, axis=1, keepdims=True))
        share = number / (len(stations) - 1)
        texcoords.append(np.column_stack([np.linspace(0, 1, 15), np.full(15, share)]))
    back = rows[-1]
    return merged(strips(rows[::-1], normals[::-1], texcoords[::-1]), polygon(back[::-1]))
