"""The paper's scene (b): lean on a white surface, reach a red plate in a dishwasher."""

import numpy as np

from w2c_sim_robot.scenes.dishes import LEAN, standing_plate
from w2c_sim_robot.scenes.lamps import DAYLIGHT
from w2c_sim_robot.scenes.objects.appliances import DOOR_TOP
from w2c_sim_robot.scenes.objects.catalogue import make_object
from w2c_sim_robot.scenes.scene import (
    Instruction,
    Scene,
    SceneObject,
    Surroundings,
)

COUNTER_SIZE = (0.60, 0.85, 0.85)
COUNTER_FRONT = 0.32
COUNTER_EDGE = -0.12
"""The left edge of the white counter, along y [m]"""
DISHWASHER_SIZE = (1.08, 0.60, 0.86)
RACK_SIZE = (0.48, 0.48, 0.14)
PLATE_SIZE = (0.25, 0.25, 0.026)
PLATE_X = (1.13, 1.17)
PLATE_Y = (0.08, 0.22)
"""Where a plate is out of reach on two feet, and within reach of a hand with support [m]"""

INSTRUCTIONS = (
    Instruction(
        prompt="Using your right hand, lean on top of the white surface",
        end_effector="right_hand",
        task="contact",
        things={"white surface": "counter"},
        thing="counter",
        description="on the white surface, near its left edge",
        share=(-0.15, 0.28, 1.0),
    ),
    Instruction(
        prompt="reach for the red plate, with the left hand",
        end_effector="left_hand",
        task="reach",
        things={"red plate": "plate"},
        thing="plate",
        description="the middle of the red plate",
        normal=(float(np.sin(LEAN)), 0.0, float(np.cos(LEAN))),
    ),
)
"""Words of the paper"""


def scenario_b(*, plate_xy: tuple[float, float] | None = None, seed: int = 0) -> Scene:
    """Return the scene of a seed; `plate_xy` puts the red plate somewhere else [m]."""
    rng = np.random.default_rng([seed, 22])
    drawn = (float(rng.uniform(*PLATE_X)), float(rng.uniform(*PLATE_Y)))
    x, y = drawn if plate_xy is None else plate_xy
    rack_x = x + float(rng.uniform(0.09, 0.13))
    rack_y = y + float(rng.uniform(-0.05, 0.05))
    door_front = rack_x - RACK_SIZE[0] / 2 - 0.03
    machine_x = door_front + DISHWASHER_SIZE[0] / 2
    mug_colour = str(rng.choice(["blue", "yellow", "green"]))
    objects = [
        make_object(
            "counter",
            "white",
            (COUNTER_FRONT + COUNTER_SIZE[0] / 2, COUNTER_EDGE - COUNTER_SIZE[1] / 2, 0.0),
            size=COUNTER_SIZE,
            variant=seed,
        ),
        make_object(
            "dishwasher",
            "grey",
            (machine_x, rack_y, 0.0),
            size=DISHWASHER_SIZE,
            variant=seed + 1,
        ),
        make_object(
            "dish_rack",
            "grey",
            (rack_x, rack_y, DOOR_TOP),
            size=RACK_SIZE,
            variant=seed + 2,
            movable=False,
        ),
        _plate("plate", "red", (x, y), seed + 3),
        _plate("plate_behind", "white", (x + 0.11, y + float(rng.uniform(-0.03, 0.03))), seed + 4),
        make_object(
            "mug",
            mug_colour,
            (float(rng.uniform(0.62, 0.76)), float(rng.uniform(-0.72, -0.58)), COUNTER_SIZE[2]),
            yaw=float(rng.uniform(-1.2, 1.2)),
            variant=seed + 5,
        ),
    ]
    return Scene(
        name="scenario_b",
        seed=seed,
        objects=tuple(objects),
        lights=DAYLIGHT,
        surroundings=Surroundings(
            floor="tiles", floor_colour=(0.66, 0.62, 0.57), wall_colour=(0.86, 0.87, 0.84)
        ),
        instructions=INSTRUCTIONS,
    )


def _plate(name: str, colour: str, place: tuple[float, float], variant: int) -> SceneObject:
    """Return a plate that stands in the rack, its middle over `place` [m]."""
    return standing_plate(name, colour, place, DOOR_TOP, size=PLATE_SIZE, variant=variant)
