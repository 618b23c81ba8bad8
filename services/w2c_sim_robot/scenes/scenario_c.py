"""The paper's scene (c): lean beside a mallet, reach a box of nails."""

import numpy as np

from w2c_sim_robot.scenes.lamps import WORKSHOP
from w2c_sim_robot.scenes.objects.catalogue import make_object
from w2c_sim_robot.scenes.scene import Instruction, Scene, Surroundings

TABLE_SIZE = (1.20, 1.7, 0.76)
TABLE_FRONT = 0.27
NAIL_BOX_X = (1.245, 1.285)
NAIL_BOX_Y = (0.06, 0.20)
"""Where the box is out of reach on two feet, and within reach of a hand with support [m]"""
ASIDE = 0.20
"""From the mallet to where the operator wants the hand in the end: clear of its head [m]"""

INSTRUCTIONS = (
    Instruction(
        prompt="Place your right hand right from the thing with the wooden handle",
        end_effector="right_hand",
        task="contact",
        things={"thing with the wooden handle": "mallet"},
        thing="mallet",
        description="on the table, two hands' breadths to the right of the mallet",
        share=(0.0, 0.0, 0.0),
        beside=(0.0, -ASIDE, 0.0),
        on=("table",),
        corrections=("Move more to the right",),
    ),
    Instruction(
        prompt="Reach for the nail box, with your left hand",
        end_effector="left_hand",
        task="reach",
        things={"nail box": "nail_box"},
        thing="nail_box",
        description="the middle of the nail box as it is seen",
        share=(0.0, 0.0, 0.5),
        normal=(-1.0, 0.0, 0.0),
    ),
)
"""Words of the paper"""


def scenario_c(*, nail_box_xy: tuple[float, float] | None = None, seed: int = 0) -> Scene:
    """Return the scene of a seed; `nail_box_xy` puts the box of nails somewhere else [m]."""
    rng = np.random.default_rng([seed, 23])
    drawn = (float(rng.uniform(*NAIL_BOX_X)), float(rng.uniform(*NAIL_BOX_Y)))
    nail_box = drawn if nail_box_xy is None else nail_box_xy
    height = TABLE_SIZE[2]
    mallet = (float(rng.uniform(0.49, 0.56)), float(rng.uniform(-0.12, -0.04)))
    toolbox = (float(rng.uniform(0.92, 1.02)), float(rng.uniform(-0.52, -0.40)))
    screwdriver = (float(rng.uniform(0.62, 0.78)), float(rng.uniform(0.30, 0.45)))
    return Scene(
        name="scenario_c",
        seed=seed,
        objects=(
            make_object(
                "table",
                "brown",
                (TABLE_FRONT + TABLE_SIZE[0] / 2, 0.0, 0.0),
                size=TABLE_SIZE,
                variant=seed,
            ),
            make_object(
                "mallet",
                "black",
                (*mallet, height),
                yaw=float(rng.normal(0.0, 0.12)),
                variant=seed + 1,
            ),
            make_object(
                "toolbox",
                str(rng.choice(["red", "blue", "green"])),
                (*toolbox, height),
                yaw=float(rng.uniform(-0.3, 0.3)),
                variant=seed + 2,
            ),
            make_object(
                "nail_box",
                "brown",
                (*nail_box, height),
                yaw=float(rng.uniform(-0.25, 0.25)),
                variant=seed + 3,
            ),
            make_object(
                "screwdriver",
                str(rng.choice(["yellow", "orange", "green"])),
                (*screwdriver, height),
                yaw=float(rng.uniform(-0.6, 0.6)),
                variant=seed + 4,
            ),
        ),
        lights=WORKSHOP,
        surroundings=Surroundings(
            floor="concrete", floor_colour=(0.60, 0.61, 0.63), wall_colour=(0.78, 0.80, 0.80)
        ),
        instructions=INSTRUCTIONS,
    )
