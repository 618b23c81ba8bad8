"""The paper's scene (d): lean on a cloth over a fridge, reach a box of crackers."""

import numpy as np

from w2c_sim_robot.scenes.lamps import DAYLIGHT
from w2c_sim_robot.scenes.objects.catalogue import make_object
from w2c_sim_robot.scenes.scene import Instruction, Scene, Surroundings

FRIDGE_SIZE = (0.60, 0.58, 0.85)
FRIDGE_FRONT = 0.30
FRIDGE_Y = -0.36
CLOTH_SIZE = (0.46, 0.46, 0.22)
CLOTH_THICK = 0.004
TABLE_SIZE = (0.85, 0.95, 0.66)
TABLE_FRONT = 0.68
TABLE_Y = 0.45
CRACKERS_X = (1.22, 1.26)
CRACKERS_Y = (0.06, 0.20)
"""Where the box is out of reach on two feet, and within reach of a hand with support [m]"""

INSTRUCTIONS = (
    Instruction(
        prompt="Place your right hand on the white cloth",
        end_effector="right_hand",
        task="contact",
        things={"white cloth": "cloth"},
        thing="cloth",
        description="the middle of what lies on the fridge",
        share=(0.0, 0.1, 1.0),
        touches=("fridge",),
        corrections=(
            "move to the left",
            "a bit down",
            "more to the left",
            "up a little",
            "a bit to the right",
            "a little more down",
        ),
    ),
    Instruction(
        prompt="with the left hand, reach the cheez it box",
        end_effector="left_hand",
        task="reach",
        things={"cheez it box": "cheez_it_box"},
        thing="cheez_it_box",
        description="the middle of the box as it is seen",
        share=(0.0, 0.0, 0.5),
        normal=(-1.0, 0.0, 0.0),
    ),
)
"""Prompts of the paper, which gives the number of its corrections but not their words"""


def scenario_d(*, crackers_xy: tuple[float, float] | None = None, seed: int = 0) -> Scene:
    """Return the scene of a seed; `crackers_xy` puts the cheez-it box somewhere else [m]."""
    rng = np.random.default_rng([seed, 24])
    drawn = (float(rng.uniform(*CRACKERS_X)), float(rng.uniform(*CRACKERS_Y)))
    crackers = drawn if crackers_xy is None else crackers_xy
    fridge_y = FRIDGE_Y + float(rng.uniform(-0.02, 0.01))
    cloth_y = fridge_y + float(rng.uniform(-0.04, 0.04))
    far = float(rng.uniform(1.15, 1.35))
    return Scene(
        name="scenario_d",
        seed=seed,
        objects=(
            make_object(
                "fridge",
                str(rng.choice(["grey", "turquoise", "red"])),
                (FRIDGE_FRONT + FRIDGE_SIZE[0] / 2, fridge_y, 0.0),
                size=FRIDGE_SIZE,
                variant=seed,
            ),
            make_object(
                "drape",
                "white",
                (
                    FRIDGE_FRONT + CLOTH_SIZE[0] / 2 - 0.03,
                    cloth_y,
                    FRIDGE_SIZE[2] + CLOTH_THICK - CLOTH_SIZE[2],
                ),
                name="cloth",
                size=CLOTH_SIZE,
                variant=seed + 1,
            ),
            make_object(
                "table",
                "brown",
                (TABLE_FRONT + TABLE_SIZE[0] / 2, TABLE_Y, 0.0),
                size=TABLE_SIZE,
                variant=seed + 2,
            ),
            make_object(
                "cheez_it_box",
                "red",
                (*crackers, TABLE_SIZE[2]),
                yaw=float(rng.uniform(-0.3, 0.3)),
                variant=seed + 3,
            ),
            make_object(
                "bowl",
                str(rng.choice(["blue", "green", "yellow"])),
                (far, float(rng.uniform(0.5, 0.75)), TABLE_SIZE[2]),
                variant=seed + 4,
            ),
        ),
        lights=DAYLIGHT,
        surroundings=Surroundings(
            floor="wood", floor_colour=(0.66, 0.55, 0.44), wall_colour=(0.88, 0.86, 0.80)
        ),
        instructions=INSTRUCTIONS,
    )
