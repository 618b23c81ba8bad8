"""The cells of the study, and what a trial is, gives, and is found by."""

from collections.abc import Iterator
from typing import Literal

import msgspec

Mode = Literal["no_force_control", "no_torque_limit", "full"]
MODES: tuple[Mode, ...] = ("no_force_control", "no_torque_limit", "full")
SPEEDS = (0.02, 0.10, 0.20, 0.30, 0.40)
"""Commanded top speeds of the hand [m/s]"""
MASSES = (0.0, 2.0, 5.0, 10.0, 12.0)
"""In the hand, unknown to the controller [kg]"""

PUBLISHED: dict[Mode, tuple[tuple[int, ...], ...]] = {
    "no_force_control": (
        (4, 1, 1, 0, 0), (5, 1, 0, 0, 0), (5, 1, 0, 0, 0), (5, 1, 0, 0, 0), (5, 1, 0, 0, 0),
    ),
    "no_torque_limit": (
        (9, 8, 7, 6, 6), (9, 8, 7, 5, 3), (9, 8, 4, 1, 1), (9, 8, 5, 1, 0), (9, 8, 4, 0, 0),
    ),
    "full": (
        (10, 10, 10, 10, 10), (10, 10, 10, 8, 6), (10, 10, 7, 4, 3), (10, 9, 7, 2, 0),
        (9, 9, 6, 1, 0),
    ),
}  # fmt: skip
"""Trials of 10 without a fall, rows of SPEEDS, columns of MASSES (Rouxel, Ivaldi and Mouret, RA-L
2024, arXiv 2312.16465)."""

Cause = Literal["", "fell", "short", "not_standing", "touched", "refused"]
"""Why a trial was not survived."""


class Cell(msgspec.Struct, frozen=True):
    """What one trial varies; also its name in the file of trials."""

    mode: Mode
    speed: float
    """Commanded [m/s]"""
    mass: float
    """[kg]"""
    trial: int
    """Which direction, from 0"""


class Target(msgspec.Struct, frozen=True):
    """The farthest point that the robot with this mass can hold, in one direction."""

    trial: int
    mass: float
    """[kg]"""
    start: tuple[float, float, float]
    """Where the hand is when the robot stands ready, in the world [m]"""
    point: tuple[float, float, float]
    """Of the hand's frame, in the world [m]"""
    direction: tuple[float, float, float]
    """Horizontal, unit, in the world"""


class TrialResult(msgspec.Struct, frozen=True):
    """What came of a trial."""

    cell: Cell
    survived: bool
    cause: Cause
    reached: float
    """Share of the way to the target that the hand came, at best within the time"""
    achieved_speed: float
    """Mean from 10 to 90 % of the way [m/s]; -1 where the hand did not come that far"""
    top_speed: float
    """Largest mean over 0.1 s on the way out [m/s]"""
    robot_seconds: float
    cpu_seconds: float
    detail: str = ""
    """The last event, or the refusal"""


def cells(
    modes: tuple[Mode, ...], speeds: tuple[float, ...], masses: tuple[float, ...], trials: int
) -> Iterator[Cell]:
    """Yield every trial of the study, trial by trial, so that any beginning of it is balanced."""
    for trial in range(trials):
        for mass in masses:
            for speed in speeds:
                for mode in modes:
                    yield Cell(mode=mode, speed=speed, mass=mass, trial=trial)
