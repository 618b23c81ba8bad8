"""Garden things."""

import numpy as np

from w2c_sim_robot.scenes.objects import textures
from w2c_sim_robot.scenes.objects.meshes import lathe, prism, tube
from w2c_sim_robot.scenes.objects.shape import (
    Collider,
    Mesh,
    Part,
    Shape,
    Size,
    Surface,
    fitted,
    merged,
)
from w2c_sim_robot.scenes.objects.solids import ellipsoid, rod

SOIL = (0.22, 0.15, 0.10)
LEAF = (0.16, 0.42, 0.14)


def _pot(r: float, z: float) -> Mesh:
    return merged(
        lathe([[0, 0], [0.68 * r, 0], [0.9 * r, 0.8 * z], [r, 0.8 * z], [r, z], [0.92 * r, z]]),
        lathe([[0.92 * r, z], [0.88 * r, 0.88 * z]]),
    )


def flower_pot(size: Size, rng: np.random.Generator) -> Shape:
    """Return a potted plant with broad leaves and a few flowers."""
    r, z = 0.07, 0.12
    soil = lathe([[0.9 * r, 0.88 * z], [0, 0.92 * z]])
    leaves, flowers = [], []
    for number in range(18):
        turn = 2.4 * number + rng.normal(0, 0.2)
        rise = 0.35 + 0.9 * (number / 18)
        length = rng.uniform(0.07, 0.1)
        out = np.array([np.cos(turn), np.sin(turn), 0.0])
        foot = np.array([0.0, 0.0, 0.95 * z + 0.006 * number])
        tip = foot + length * (np.cos(rise) * out + np.sin(rise) * np.array([0, 0, 1.0]))
        leaves.append(rod([foot, 0.5 * (foot + tip), tip], np.array([0.002, 0.002, 0.001]), 6))
        blade = ellipsoid((0.034, 0.019, 0.003))
        tilt = np.array(
            [[np.cos(rise), 0, -np.sin(rise)], [0, 1, 0], [np.sin(rise), 0, np.cos(rise)]]
        )
        about = np.array([[out[0], -out[1], 0], [out[1], out[0], 0], [0, 0, 1]])
        leaves.append(
            blade.rotated(about @ tilt).moved((float(tip[0]), float(tip[1]), float(tip[2])))
        )
        if number % 5 == 4:
            flowers.append(
                ellipsoid((0.016, 0.016, 0.009)).moved(
                    (float(1.1 * tip[0]), float(1.1 * tip[1]), float(tip[2] + 0.012))
                )
            )
    return fitted(
        size,
        (
            Part(_pot(r, z), Surface("main", textures.speckle(rng, 0.025), 0.1), "pot"),
            Part(soil, Surface(SOIL, textures.speckle(rng, 0.2, 4), 0.0), "soil"),
            Part(merged(*leaves), Surface(LEAF, textures.speckle(rng, 0.03), 0.3), "leaves"),
            Part(merged(*flowers), Surface("accent", None, 0.2), "flower"),
        ),
        (
            Collider("cylinder", (0.85 * r, z / 2), (0, 0, z / 2)),
            Collider("cylinder", (0.6 * r, 0.05), (0, 0, z + 0.05)),
        ),
    )


def cactus(size: Size, rng: np.random.Generator) -> Shape:
    """Return a cactus in a pot: a ribbed column with two arms and pale spines."""
    r, z = 0.055, 0.08
    soil = lathe([[0.9 * r, 0.88 * z], [0, 0.9 * z]])
    body = ellipsoid((0.034, 0.034, 0.085)).moved((0, 0, 0.15))
    arms = [
        rod(
            [
                [0, s * 0.02, h],
                [0, s * 0.052, h + 0.004],
                [0, s * 0.06, h + 0.02],
                [0, s * 0.06, h + 0.05],
            ],
            0.013,
        )
        for s, h in ((1, 0.14), (-1, 0.16))
    ]
    tops = [
        ellipsoid((0.013, 0.013, 0.013)).moved((0, s * 0.06, h + 0.05))
        for s, h in ((1, 0.14), (-1, 0.16))
    ]
    spines = []
    for ring in range(9):
        height = -0.8 + 0.2 * ring
        wide = 0.034 * np.sqrt(1 - height**2)
        for number in range(12):
            turn = 2 * np.pi * (number + 0.5 * (ring % 2)) / 12
            out = np.array([np.cos(turn), np.sin(turn), 0.25 * height])
            foot = np.array([wide * out[0], wide * out[1], 0.15 + 0.085 * height])
            spines.append(rod([foot, foot + 0.01 * out], np.array([0.0011, 0.0003]), 5))
    return fitted(
        size,
        (
            Part(_pot(r, z), Surface("main", textures.speckle(rng, 0.025), 0.1), "pot"),
            Part(soil, Surface(SOIL, textures.speckle(rng, 0.2, 4), 0.0)),
            Part(merged(body, *arms, *tops), Surface((0.20, 0.44, 0.22), None, 0.15), "stem"),
            Part(merged(*spines), Surface((0.95, 0.92, 0.75), None, 0.1), "spines"),
        ),
        (
            Collider("cylinder", (0.85 * r, z / 2), (0, 0, z / 2)),
            Collider("cylinder", (0.034, 0.075), (0, 0, 0.155)),
        ),
    )


def watering_can(size: Size, rng: np.random.Generator) -> Shape:
    """Return a watering can: its rose to the left, its handle to the right."""
    body = lathe([[0, 0], [0.075, 0], [0.075, 0.13], [0.06, 0.15], [0.045, 0.15]])
    inner = lathe([[0.045, 0.15], [0.045, 0.14], [0.07, 0.12], [0.07, 0.01], [0, 0.01]])
    spout = rod([[0, 0.06, 0.03], [0, 0.13, 0.09], [0, 0.2, 0.18]], np.array([0.016, 0.012, 0.01]))
    rose = lathe([[0.01, 0], [0.03, 0.025], [0.028, 0.03], [0, 0.034]])
    tilt = np.radians(-40.0)
    turn = np.array([[1, 0, 0], [0, np.cos(tilt), -np.sin(tilt)], [0, np.sin(tilt), np.cos(tilt)]])
    angle = np.linspace(-0.45 * np.pi, 0.85 * np.pi, 20)
    ear = tube(
        np.column_stack([0 * angle, -0.06 - 0.065 * np.cos(angle), 0.11 + 0.08 * np.sin(angle)]),
        0.007,
    )
    zinc = Surface("main", textures.brushed(rng), 0.6)
    return fitted(
        size,
        (
            Part(merged(body, inner), zinc),
            Part(merged(spout, rose.rotated(turn).moved((0, 0.2, 0.18))), zinc, "spout"),
            Part(ear, zinc, "handle"),
        ),
        (
            Collider("cylinder", (0.075, 0.075), (0, 0, 0.075)),
            Collider("box", (0.01, 0.05, 0.05), (0, 0.15, 0.12)),
        ),
    )


def trowel(size: Size, rng: np.random.Generator) -> Shape:
    """Return a garden trowel that lies flat, its handle towards the robot."""
    along = np.linspace(-0.16, -0.03, 8)
    thick = np.interp(along, [-0.16, -0.14, -0.08, -0.03], [0.009, 0.013, 0.010, 0.012])
    handle = rod(np.column_stack([along, 0 * along, 0 * along + 0.013]), thick, 14)
    neck = rod([[-0.03, 0, 0.013], [0.0, 0, 0.017], [0.02, 0, 0.006]], 0.0045, 8)
    outline = np.array(
        [
            [0.145, 0.0],
            [0.125, 0.02],
            [0.08, 0.035],
            [0.02, 0.03],
            [0.005, 0.015],
            [0.005, -0.015],
            [0.02, -0.03],
            [0.08, -0.035],
            [0.125, -0.02],
        ]
    )
    blade = prism(outline, 0.006, 0.001)
    return fitted(
        size,
        (
            Part(handle, Surface("main", textures.wood(rng, 128, 64, 1), 0.3), "handle"),
            Part(
                merged(blade, neck),
                Surface((0.55, 0.56, 0.58), textures.brushed(rng), 0.9),
                "blade",
                "metal",
            ),
        ),
        (
            Collider("box", (0.065, 0.012, 0.013), (-0.095, 0, 0.013)),
            Collider("box", (0.07, 0.03, 0.004), (0.075, 0, 0.004)),
        ),
    )
