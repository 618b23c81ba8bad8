"""The paper's scene (a): lean on the book, then reach the cup that was out of reach."""

import numpy as np

from w2c.errors import ConfigError
from w2c_sim_robot.scenes.objects.catalogue import make_object
from w2c_sim_robot.scenes.scene import Instruction, Light, Scene, SceneObject, Surroundings

TABLE_DEPTH = 1.15
TABLE_WIDTH = 1.7
TABLE_FRONT = 0.27
"""Distance of the table's front edge from the soles' midpoint [m]: clear of the robot's feet
and thighs"""
BOOK_SIZE = (0.27, 0.20, 0.04)
CUP_SIZE = (0.125, 0.09, 0.105)
INSTRUCTIONS = (
    Instruction(
        prompt="Place your right hand on top of the book",
        end_effector="right_hand",
        task="contact",
        things={"book": "book"},
        thing="book",
        description="near the middle of the book",
    ),
    Instruction(
        prompt="with your left hand, reach for the cup",
        end_effector="left_hand",
        task="reach",
        things={"cup": "cup"},
        thing="cup",
        description="the middle of the cup as it is seen",
        share=(0.0, 0.0, 0.5),
        normal=(-1.0, 0.0, 0.0),
    ),
)
"""Words of the paper"""


def scenario_a(
    *,
    book_xy: tuple[float, float] = (0.50, -0.25),
    cup_xy: tuple[float, float] = (1.08, 0.16),
    book_yaw: float = 0.12,
    cup_yaw: float = 0.6,
    table_height: float = 0.80,
    book_colour: str = "red",
    cup_colour: str = "blue",
    distractors: bool = True,
    seed: int = 0,
) -> Scene:
    """Return the scene; positions [m] are in the world, of the middle of the object's underside.

    The book is fixed: a robot leans on it, at `scene.object("book").top_in_world`.

    Raises:
        ConfigError: an object would not stand on the table.
    """
    for name, (x, y) in (("book", book_xy), ("cup", cup_xy)):
        if not (
            TABLE_FRONT + 0.05 < x < TABLE_FRONT + TABLE_DEPTH - 0.05
            and abs(y) < TABLE_WIDTH / 2 - 0.05
        ):
            raise ConfigError(
                f"the {name} at ({x:g}, {y:g}) m is not on the table: x {TABLE_FRONT + 0.05:g} to "
                f"{TABLE_FRONT + TABLE_DEPTH - 0.05:g}, y within {TABLE_WIDTH / 2 - 0.05:g}"
            )
    objects: list[SceneObject] = [
        make_object(
            "table",
            "brown",
            (TABLE_FRONT + TABLE_DEPTH / 2, 0.0, 0.0),
            size=(TABLE_DEPTH, TABLE_WIDTH, table_height),
            variant=seed,
        ),
        make_object(
            "book",
            book_colour,
            (*book_xy, table_height),
            size=BOOK_SIZE,
            yaw=book_yaw,
            variant=seed + 3,
            movable=False,
        ),
        make_object(
            "mug",
            cup_colour,
            (*cup_xy, table_height),
            name="cup",
            size=CUP_SIZE,
            yaw=cup_yaw,
            variant=seed + 1,
        ),
    ]
    if distractors:
        objects += [
            make_object("bottle", "green", (0.90, -0.48, table_height), yaw=1.0, variant=seed + 2),
            make_object("bowl", "yellow", (1.10, -0.20, table_height), variant=seed + 4),
        ]
    return Scene(
        name="scenario_a",
        seed=seed,
        objects=tuple(objects),
        lights=(
            Light(
                position=(-0.6, 1.6, 3.2),
                direction=(0.42, -0.38, -0.82),
                brightness=0.62,
                warmth=0.2,
            ),
            Light(
                position=(1.5, -2.0, 3.0),
                direction=(-0.2, 0.55, -0.81),
                brightness=0.28,
                warmth=-0.2,
                shadow=False,
            ),
        ),
        surroundings=Surroundings(floor="tiles"),
        instructions=INSTRUCTIONS,
    )


def random_layout(rng: np.random.Generator, cup_x: tuple[float, float], *, seed: int = 0) -> Scene:
    """Return scene (a) with new places; `cup_x` is the band the controller computed [m]."""
    colours = rng.permutation(["red", "blue", "green", "yellow", "orange", "purple"])
    return scenario_a(
        # Nearer than 0.43 m the middle of the book is below the picture of a robot standing ready.
        book_xy=(float(rng.uniform(0.46, 0.55)), float(rng.uniform(-0.30, -0.20))),
        cup_xy=(float(rng.uniform(*cup_x)), float(rng.uniform(0.05, 0.25))),
        book_yaw=float(rng.uniform(-0.3, 0.3)),
        cup_yaw=float(rng.uniform(-np.pi, np.pi)),
        book_colour=str(colours[0]),
        cup_colour=str(colours[1]),
        seed=seed,
    )
