"""A wall to put a hand on while one foot is lifted: the paper's example of remote work."""

import numpy as np

from w2c_sim_robot.scenes.lamps import DAYLIGHT
from w2c_sim_robot.scenes.objects.catalogue import make_object
from w2c_sim_robot.scenes.scene import Instruction, Scene, Surroundings

WALL_SIZE = (0.12, 2.6, 2.2)
WALL_X = (0.57, 0.66)
"""Of the side towards the robot [m]"""
HAND_HEIGHT = 1.15
HAND_Y = -0.20
WINDOW_SIZE = (0.06, 0.62, 0.70)
PICTURE_SIZE = (0.02, 0.30, 0.40)


def scenario_e(*, wall_x: float | None = None, seed: int = 0) -> Scene:
    """Return the scene of a seed; `wall_x` puts the wall's near side somewhere else [m]."""
    rng = np.random.default_rng([seed, 25])
    drawn = float(rng.uniform(*WALL_X))
    front = drawn if wall_x is None else wall_x
    window_y = float(rng.uniform(-0.86, -0.72))
    picture = (float(rng.uniform(0.18, 0.28)), float(rng.uniform(0.84, 0.92)))
    wall = make_object(
        "wall",
        str(rng.choice(["white", "yellow", "turquoise", "grey"])),
        (front + WALL_SIZE[0] / 2, 0.0, 0.0),
        size=WALL_SIZE,
        variant=seed,
    )
    return Scene(
        name="scenario_e",
        seed=seed,
        objects=(
            wall,
            make_object(
                "window",
                "white",
                (front - WINDOW_SIZE[0] / 2, window_y, 0.78),
                size=WINDOW_SIZE,
                variant=seed + 1,
            ),
            make_object(
                "poster",
                "black",
                (front - PICTURE_SIZE[0] / 2, *picture),
                name="picture",
                size=PICTURE_SIZE,
                variant=seed + 2,
            ),
            make_object(
                "bucket",
                str(rng.choice(["blue", "red", "yellow"])),
                (front - 0.17, float(rng.uniform(0.62, 0.80)), 0.0),
                variant=seed + 3,
            ),
        ),
        lights=DAYLIGHT,
        surroundings=Surroundings(
            floor="wood", floor_colour=(0.60, 0.52, 0.44), wall_colour=(0.84, 0.85, 0.86)
        ),
        instructions=(
            Instruction(
                prompt="Place your right hand on the wall, to the right of the picture",
                end_effector="right_hand",
                task="contact",
                things={"wall": "wall", "picture": "picture"},
                thing="wall",
                description="the wall before the right shoulder, between picture and window",
                share=(-0.5, HAND_Y / WALL_SIZE[1], HAND_HEIGHT / WALL_SIZE[2]),
                normal=(-1.0, 0.0, 0.0),
            ),
            Instruction(prompt="Lift your left foot", end_effector="left_foot", task="lift"),
        ),
    )
