"""Where to reach: in a random direction as far as the robot could with its true mass."""

from dataclasses import replace
from functools import cache
from typing import Final

import numpy as np

from w2c.errors import ControlError
from w2c.library import library
from w2c.messages import EndEffector
from w2c_evaluation.robustness.grid import Target

HAND: Final[EndEffector] = "right_hand"
"""The ball-ended one: the left wrist bears 8 Nm, less than 5 kg in the hand."""
HAND_INDEX: Final = 3
AZIMUTHS = (-75.0, 20.0)
"""To the right and to the left of straight ahead [deg]"""
HEIGHTS = (0.75, 1.25)
"""[m]"""
DRAWS = 20

PHYSICAL_LIMITS = {"cop_x": 0.09, "cop_y": 0.055, "torque_fraction": 0.85}
"""Where the static limit is taken to be: the sole ends at 0.10 and 0.065 m, motors at 100 %."""


def find_target(trial: int, mass: float, seed: int) -> Target:
    """Return the farthest point of a trial's direction with this mass in the hand.

    The direction depends on seed and trial alone: the same for all masses, speeds and modes.

    Raises:
        ControlError: no direction in DRAWS draws that the hand can get to with every mass.
    """
    rng = np.random.default_rng((seed, trial))
    start = _start()
    for _ in range(DRAWS):
        azimuth = np.radians(rng.uniform(*AZIMUTHS))
        height = float(rng.uniform(*HEIGHTS))
        direction = (float(np.cos(azimuth)), float(np.sin(azimuth)), 0.0)
        try:
            distance = _farthest(mass, direction, height)
        except ControlError:
            continue
        point = (start[0] + distance * direction[0], start[1] + distance * direction[1], height)
        return Target(trial=trial, mass=mass, start=start, point=point, direction=direction)
    raise ControlError(f"no direction to reach in {DRAWS} draws of seed {seed}, trial {trial}")


def _farthest(mass: float, direction: tuple[float, float, float], height: float) -> float:
    start = _start()
    parameters = library("controller_parameters")()
    physical = replace(parameters, limits=replace(parameters.limits, **PHYSICAL_LIMITS))
    distance = library("farthest_reach")(
        library("loaded_description")((0.0, mass)),
        end_effector=HAND,
        origin=start[:2],
        height=height,
        direction=direction[:2],
        normal=(-direction[0], -direction[1], 0.0),
        parameters=physical,
    )
    return float(distance)


@cache
def _start() -> tuple[float, float, float]:
    """Return where the hand of the robot is that stands ready [m]."""
    x, y, z = library("study_robot")().truth().end_effector_positions[HAND_INDEX].tolist()
    return x, y, z
