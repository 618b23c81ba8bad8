"""Where book and cup stand: drawn at random, from the controller's own limits.

The cup must be out of reach on two feet, and within reach with the hand on the book: that is the
point of the paper. Both limits are the controller's, found by its own look-ahead.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from w2c.errors import ConfigError, ControlError, GoalRefusedError
from w2c.geometry import Vector
from w2c.library import library
from w2c.messages import PlaceGoal, RobotDescription

TABLE_HEIGHT_M = 0.80
BOOK_HEIGHT_M = 0.04
CUP_GRASP_HEIGHT_M = 0.06
"""Of the point that the hand goes to, above the table"""
CUP_RADIUS_M = 0.04
CLEARLY_OUT_OF_REACH_M = 0.05
SAFELY_WITHIN_REACH_M = 0.02
DRAWS = 30


@dataclass(frozen=True)
class Layout:
    """One layout of scene (a), in the world [m]."""

    book_xy: tuple[float, float]
    cup_xy: tuple[float, float]
    reach_on_feet: float
    """How far ahead the left hand gets at the cup's height, on two feet"""
    reach_with_support: float
    """The same with the right hand on the book"""

    @property
    def places(self) -> dict[str, Vector]:
        """Return the points (3,) of book and cup that a hand goes to."""
        return {
            "book": np.array([*self.book_xy, TABLE_HEIGHT_M + BOOK_HEIGHT_M]),
            "cup": np.array([*self.cup_xy, TABLE_HEIGHT_M + CUP_GRASP_HEIGHT_M]),
        }

    def __str__(self) -> str:
        """Say it for a log."""
        return (
            f"book at ({self.book_xy[0]:.2f}, {self.book_xy[1]:.2f}) m, "
            f"cup at ({self.cup_xy[0]:.2f}, {self.cup_xy[1]:.2f}) m; the left hand gets to "
            f"x = {self.reach_on_feet:.3f} m on two feet, "
            f"to x = {self.reach_with_support:.3f} m with the right hand on the book"
        )


def draw_layout(seed: int, scene_path: Path) -> Layout:
    """Draw a layout, write its scene file, and return it.

    Raises:
        ConfigError: no layout with a wide enough band in DRAWS draws.
    """
    rng = np.random.default_rng(seed)
    description: RobotDescription = library("make_description")()
    for _ in range(DRAWS):
        layout = _attempt(rng, description)
        if layout is not None:
            break
    else:
        raise ConfigError(f"no layout in {DRAWS} draws of seed {seed}; choose another --seed")
    scene = library("scenario_a")(
        book_xy=layout.book_xy,
        cup_xy=layout.cup_xy,
        book_yaw=float(rng.uniform(-0.2, 0.2)),
        cup_yaw=float(rng.uniform(-np.pi, np.pi)),
        table_height=TABLE_HEIGHT_M,
        seed=seed,
    )
    library("save_scene")(scene, scene_path)
    return layout


def _attempt(rng: np.random.Generator, description: RobotDescription) -> Layout | None:
    """Return a layout, or None where the support opens no band for the cup."""
    book = (float(rng.uniform(0.46, 0.54)), float(rng.uniform(-0.30, -0.20)))
    cup_y = float(rng.uniform(0.08, 0.22))
    support = PlaceGoal(
        goal_id="layout",
        end_effector="right_hand",
        task="contact",
        point=np.array([*book, TABLE_HEIGHT_M + BOOK_HEIGHT_M]),
        normal=np.array([0.0, 0.0, 1.0]),
    )
    ray = {
        "end_effector": "left_hand",
        "origin": (0.0, cup_y),
        "direction": (1.0, 0.0),
        "height": TABLE_HEIGHT_M + CUP_GRASP_HEIGHT_M,
    }
    farthest_reach = library("farthest_reach")
    try:
        on_feet = float(farthest_reach(description, **ray))
        with_support = float(farthest_reach(description, **ray, support=support))
    except (ControlError, GoalRefusedError):
        return None
    low, high = on_feet + CLEARLY_OUT_OF_REACH_M, with_support - SAFELY_WITHIN_REACH_M
    if high <= low:
        return None
    cup_x = float(rng.uniform(low, high)) + CUP_RADIUS_M
    return Layout(book, (cup_x, cup_y), on_feet, with_support)
