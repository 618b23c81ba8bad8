"""Kitchen appliances, and the rack that a dishwasher holds."""

from itertools import pairwise

import numpy as np

from w2c_sim_robot.scenes.objects import textures
from w2c_sim_robot.scenes.objects.meshes import box, lathe, prism, rounded_rectangle
from w2c_sim_robot.scenes.objects.shape import (
    Collider,
    Part,
    Shape,
    Size,
    Surface,
    box_collider,
    merged,
)
from w2c_sim_robot.scenes.objects.solids import disc, rod, slab

STEEL = (0.70, 0.71, 0.73)
DARK = (0.13, 0.13, 0.14)
DOOR_SHARE = 0.48
"""Of the length of an open dishwasher: its door, folded down before it"""
DOOR_TOP = 0.19
"""Height of the upper side of the open door [m]"""
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
