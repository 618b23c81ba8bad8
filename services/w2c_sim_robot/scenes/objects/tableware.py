"""Turned things: mugs, bowls, plates, bottles, cans, jugs."""

import numpy as np

from w2c_sim_robot.scenes.objects import textures
from w2c_sim_robot.scenes.objects.meshes import arc, lathe, tube
from w2c_sim_robot.scenes.objects.shape import (
    Collider,
    Part,
    Shape,
    Size,
    Surface,
    cylinder_collider,
    merged,
)

GLAZE_INSIDE = (0.95, 0.94, 0.90)


def mug(size: Size, rng: np.random.Generator) -> Shape:
    """Return a glazed mug; its extent along x includes the handle, which points to -x."""
    _, width, z = size
    r = width / 2
    wall = 0.09 * r
    outer = lathe(
        [
            [0, 0],
            [0.84 * r, 0],
            [0.93 * r, 0.02 * z],
            [r, 0.09 * z],
            [r, 0.96 * z],
            [r - wall / 2, z],
        ]
    )
    inner = lathe(
        [
            [r - wall / 2, z],
            [r - wall, 0.96 * z],
            [r - wall, 0.1 * z],
            [0.8 * r, 0.06 * z],
            [0, 0.06 * z],
        ]
    )
    handle = tube(
        arc((-r, 0, 0.52 * z), (0.62 * r, 0.33 * z), 0.5 * np.pi, 1.5 * np.pi),
        0.13 * r,
        flatten=1.3,
    )
    glaze = textures.rings(rng) if rng.random() < 0.5 else textures.speckle(rng, 0.015)
    return Shape(
        (
            Part(outer, Surface("main", glaze, 0.85)),
            Part(handle, Surface("main", None, 0.85), "handle"),
            Part(inner, Surface(GLAZE_INSIDE, None, 0.7)),
        ),
        (Collider("cylinder", (r, z / 2), (0, 0, z / 2)),),
    )


def bowl(size: Size, rng: np.random.Generator) -> Shape:
    """Return an open bowl on a foot."""
    r, z = size[1] / 2, size[2]
    t = np.linspace(0, 1, 9)
    curve = np.column_stack(
        [
            0.45 * r + 0.55 * r * np.sin(t * np.pi / 2),
            z * (0.08 + 0.92 * (1 - np.cos(t * np.pi / 2))),
        ]
    )
    foot = [[0, 0.02 * z], [0.4 * r, 0.02 * z], [0.4 * r, 0], [0.46 * r, 0]]
    inner = curve[::-1] - np.array([0.035 * r, -0.0])
    outer = lathe(np.vstack([foot, curve, [[0.985 * r, 1.015 * z]]]))
    inside = lathe(
        np.vstack([[[0.985 * r, 1.015 * z]], inner[:-1], [[0.36 * r, 0.13 * z], [0, 0.11 * z]]])
    )
    return Shape(
        (
            Part(outer, Surface("main", textures.rings(rng, bands=1), 0.8)),
            Part(inside, Surface("main", textures.speckle(rng, 0.012), 0.8)),
        ),
        (Collider("cylinder", (0.97 * r, z / 2), (0, 0, z / 2)),),
    )


def plate(size: Size, rng: np.random.Generator) -> Shape:
    """Return a flat plate with a raised rim, and a ring printed on it."""
    r, z = size[1] / 2, size[2]
    under: list[list[float]] = [
        [0, 0],
        [0.6 * r, 0],
        [0.68 * r, 0.25 * z],
        [r, 0.88 * z],
        [0.995 * r, z],
    ]
    over: list[list[float]] = [
        [0.995 * r, z],
        [0.94 * r, 0.92 * z],
        [0.7 * r, 0.42 * z],
        [0.62 * r, 0.25 * z],
        [0, 0.25 * z],
    ]
    ring = [[0.9 * r, 0.875 * z], [0.86 * r, 0.805 * z]]
    return Shape(
        (
            Part(
                merged(lathe(under), lathe(over)), Surface("main", textures.speckle(rng, 0.01), 0.8)
            ),
            Part(lathe(ring).moved((0, 0, 8e-4)), Surface("accent", None, 0.8)),
        ),
        # Hollow, as it is seen: a disc, and a ring of balls for the rim.
        (Collider("cylinder", (0.68 * r, 0.15 * z), (0, 0, 0.15 * z)), *_rim(r, z)),
    )


def _rim(r: float, z: float) -> tuple[Collider, ...]:
    """Return a ring of balls as the rim of a plate of this radius and height [m]."""
    angles = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
    return tuple(
        Collider("sphere", (0.2 * z,), (0.84 * r * np.cos(a), 0.84 * r * np.sin(a), 0.62 * z))
        for a in angles.tolist()
    )


def bottle(size: Size, rng: np.random.Generator) -> Shape:
    """Return a bottle with a paper label and a cap."""
    r, z = size[1] / 2, size[2]
    t = np.linspace(0, 1, 10)
    shoulder = np.column_stack([r - 0.64 * r * (3 * t**2 - 2 * t**3), z * (0.6 + 0.24 * t)])
    body = lathe(
        np.vstack(
            [[[0, 0], [0.9 * r, 0], [r, 0.03 * z]], shoulder, [[0.36 * r, 0.93 * z], [0, 0.93 * z]]]
        )
    )
    cap = lathe([[0.42 * r, 0.92 * z], [0.42 * r, z], [0, z]])
    sleeve = lathe([[1.012 * r, 0.2 * z], [1.012 * r, 0.5 * z]])
    return Shape(
        (
            Part(body, Surface("main", None, 0.95)),
            Part(cap, Surface("accent", None, 0.4), "cap"),
            Part(sleeve, Surface((0.95, 0.94, 0.90), textures.label(rng), 0.15), "label"),
        ),
        (
            Collider("cylinder", (r, 0.32 * z), (0, 0, 0.32 * z)),
            Collider("cylinder", (0.42 * r, 0.18 * z), (0, 0, 0.82 * z)),
        ),
    )


def can(size: Size, rng: np.random.Generator) -> Shape:
    """Return a drink can: painted side, metal ends."""
    r, z = size[1] / 2, size[2]
    side = lathe([[0.88 * r, 0.03 * z], [r, 0.09 * z], [r, 0.9 * z], [0.86 * r, 0.975 * z]])
    ends = lathe([[0, 0.02 * z], [0.8 * r, 0], [0.88 * r, 0.03 * z]])
    lid = lathe(
        [[0.86 * r, 0.975 * z], [0.84 * r, z], [0.79 * r, z], [0.77 * r, 0.975 * z], [0, 0.975 * z]]
    )
    tab = lathe([[0.0, 0.985 * z], [0.3 * r, 0.985 * z]][::-1], scale=(1.0, 0.6)).moved(
        (0.2 * r, 0, 5e-4)
    )
    return Shape(
        (
            Part(side, Surface("main", textures.label(rng, stripe=(0.35, 0.35, 0.38)), 0.8)),
            Part(merged(ends, lid), Surface((0.74, 0.75, 0.77), None, 1.0)),
            Part(tab, Surface((0.56, 0.57, 0.59), None, 1.0)),
        ),
        (cylinder_collider(size),),
    )


def jug(size: Size, rng: np.random.Generator) -> Shape:
    """Return a bellied jug with a handle at its back (+x)."""
    r, z = size[1] / 2, size[2]
    t = np.linspace(0, 1, 14)
    belly = np.column_stack([r * (0.66 + 0.34 * np.sin(np.pi * (1.25 * t + 0.06))), z * t])
    thick = np.array([0.07 * r, 0.0])
    outer = lathe(np.vstack([[[0, 0]], belly]))
    inner = lathe(np.vstack([belly[::-1][:-1] - thick, [[0, 0.05 * z]]]))
    reach = float(belly[9, 0])
    handle = tube(
        arc((reach - 0.05 * r, 0, 0.62 * z), (0.55 * r, 0.26 * z), -0.5 * np.pi, 0.5 * np.pi),
        0.1 * r,
        flatten=1.4,
    )
    glaze = textures.rings(rng, bands=2)
    return Shape(
        (
            Part(outer, Surface("main", glaze, 0.8)),
            Part(handle, Surface("main", glaze, 0.8), "handle"),
            Part(inner, Surface("accent", None, 0.4)),
        ),
        (cylinder_collider(size),),
    )
