"""The ways of a hand: to a surface, to a point, and back."""

import numpy as np
import numpy.typing as npt

from w2c_controller.goals import Goal
from w2c_controller.grasp import approach_direction
from w2c_controller.parameters import Motion
from w2c_controller.trajectory import Path, curved, straight

Vector = npt.NDArray[np.float64]

UP = np.array([0.0, 0.0, 1.0])


def way_back(goal: Goal) -> Vector:
    """Return the direction (3,) from which a goal is approached, out of the surface.

    Along the normal for a contact; against the fingers for a reach.
    """
    if goal.task == "contact":
        return goal.normal
    return -approach_direction(goal.target, goal.normal)


def approach(goal: Goal, start: Vector, motion: Motion) -> Path:
    """Return the path to a goal: a curve to a point before it, then straight on.

    To a contact the second leg goes on below the surface, slowly, because the surface ends it. To a
    reach it ends a little before the point.
    """
    away = way_back(goal)
    via = goal.target + motion.via_height * away
    first = curved(start, via, away, motion.speed)
    if goal.task == "contact":
        below = goal.target - motion.overtravel * away
        return Path((first, straight(via, below, motion.touch_speed)))
    before = goal.target + motion.reach_standoff * away
    return Path((first, straight(via, before, motion.reach_speed)))


def retreat(start: Vector, away: Vector, rest: Vector, motion: Motion) -> Path:
    """Return the path back: away from the surface first, then to where the hand rests."""
    lift = start + motion.retreat_height * away
    return Path((straight(start, lift, motion.speed), curved(lift, rest, UP, motion.speed)))


def lift(start: Vector, away: Vector, motion: Motion) -> Path:
    """Return the path of a foot off the ground: it stays in the air."""
    return Path((straight(start, start + motion.retreat_height * away, motion.speed),))


def at(point: Vector) -> Path:
    """Return a path that stays where it is."""
    return Path((straight(point, point, 1.0),))
