"""The ways of an end effector: to a surface, to a point, and back, over what stands between.

A way is a curve to a point before the target, then straight on along the normal (or along the
fingers). Where the camera saw something between, the curve bows upwards or sideways until the arm
clears it; the smallest bow that does is taken.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from w2c.errors import GoalRefusedError
from w2c_controller.goals.goals import Goal
from w2c_controller.motion.obstacles import find_obstacle
from w2c_controller.motion.terrain import Terrain
from w2c_controller.motion.trajectory import Bow, Leg, Path, make_leg, straight
from w2c_controller.parameters import Motion

Vector = npt.NDArray[np.float64]

UP = np.array([0.0, 0.0, 1.0])
MOVING = 0.03
"""A faster end effector leaves in the direction in which it moves [m/s]"""
HIGHEST_BOW = 0.9
"""Of the control points [m]; the curve rises by three quarters of it."""
BOW_STEP = 0.05
SIDEWAYS = (0.0, 0.15, -0.15, 0.3, -0.3)


DIRECT = Bow()
BOWS = sorted(
    (
        Bow(BOW_STEP * n, side)
        for n in range(round(HIGHEST_BOW / BOW_STEP) + 1)
        for side in SIDEWAYS
    ),
    key=lambda bow: bow.detour,
)
UPWARDS = [bow for bow in BOWS if bow.side == 0.0]
PLANNED_MARGIN = 0.01
"""Of a planned way, so that it clears also from a place a little beside [m]"""
HIGHER = 0.1
"""A planned bow may grow by this when the hand sets out [m]"""


def way_back(goal: Goal) -> Vector:
    """Return the direction (3,) from which a goal is approached, out of the surface.

    Along the normal for a contact; against the fingers for a reach.
    """
    if goal.task == "contact":
        return goal.normal
    return -goal.fingers


def approach(goal: Goal, start: Vector, velocity: Vector, motion: Motion) -> Path:
    """Return the path to a goal: a curve to a point before it, then straight on.

    To a contact the second leg goes on below the surface, slowly, because the surface ends it. The
    path begins with the velocity that the end effector has: a goal may change while it moves.

    Args:
        goal: With the terrain that the way must clear, or without.
        start: (3,) where the end effector is [m].
        velocity: (3,) of it [m/s].
        motion: Speeds and distances.

    Raises:
        GoalRefusedError: something is in the way; says what.
    """
    away = way_back(goal)
    via = goal.target + motion.via_height * away
    if goal.task == "contact":
        last = straight(via, goal.target - motion.overtravel * away, motion.touch_speed)
    else:
        last = straight(via, goal.target, motion.reach_speed)
    if goal.terrain is None:
        return Path((curve(start, velocity, via, away, DIRECT, motion.speed), last))
    bows = _planned(goal.terrain)
    first, _, margin = _clearest(goal.terrain, start, velocity, via, away, motion, bows)
    if margin < 0.0:
        direct = curve(start, velocity, via, away, DIRECT, motion.speed)
        raise GoalRefusedError(_blocked("the way", goal.terrain, direct))
    if goal.terrain.room(via, goal.target) < 0.0:
        raise GoalRefusedError(_no_room(goal.terrain, goal.target))
    return Path((first, last))


def may_cut(terrain: Terrain | None, start: Vector, end: Vector, motion: Motion) -> bool:
    """Return whether a hand that cannot get over the surface may go straight to its point.

    Args:
        terrain: That the way must clear; None: nothing is known of it.
        start: (3,) where the hand is [m].
        end: (3,) of the point [m].
        motion: Speeds.
    """
    if terrain is None:
        return True
    margin, _ = terrain.margin(straight(start, end, motion.reach_speed))
    return margin >= 0.0


def retreat(
    start: Vector,
    away: Vector,
    rest: Vector,
    motion: Motion,
    velocity: Vector | None = None,
    terrain: Terrain | None = None,
) -> Path:
    """Return the path back: away from the surface first, then to where the hand rests.

    A hand must come back: where no bow clears the terrain, the one that clears most is taken.

    Args:
        start: (3,) [m].
        away: (3,) unit, the way the hand came.
        rest: (3,) [m].
        motion: Speeds and distances.
        velocity: (3,) at the start [m/s]; None: at rest.
        terrain: That the way must clear; None: nothing is known of it.
    """
    lifted = start + motion.retreat_height * away
    steps = np.linspace(0.0, 1.0, 4)[:, None]
    first = make_leg(start + steps * (lifted - start), motion.speed, velocity)
    if terrain is None:
        return Path((first, curve(lifted, np.zeros(3), rest, UP, DIRECT, motion.speed)))
    second, _, _ = _clearest(terrain, lifted, np.zeros(3), rest, UP, motion, UPWARDS, home=True)
    return Path((first, second))


def plan_approach(goal: Goal, start: Vector, motion: Motion) -> Goal:
    """Return a goal whose terrain knows the bow that clears it, so that the loop need not search.

    Args:
        goal: With the terrain that the way must clear.
        start: (3,) where the end effector is [m].
        motion: Speeds and distances.

    Raises:
        GoalRefusedError: something is in the way; says what.
    """
    approach(goal, start, np.zeros(3), motion)
    if goal.terrain is None:
        return goal
    away = way_back(goal)
    via = goal.target + motion.via_height * away
    _, bow, _ = _clearest(
        goal.terrain, start, np.zeros(3), via, away, motion, BOWS, least=PLANNED_MARGIN
    )
    return replace(goal, terrain=replace(goal.terrain, planned=bow))


def check_retreat(goal: Goal, rest: Vector, motion: Motion) -> None:
    """Refuse a goal from which no way leads back. Raises GoalRefusedError, with what blocks it."""
    if goal.terrain is None:
        return
    lifted = goal.target + motion.retreat_height * way_back(goal)
    at_rest = np.zeros(3)
    _, _, margin = _clearest(goal.terrain, lifted, at_rest, rest, UP, motion, UPWARDS, home=True)
    if margin < 0.0:
        direct = curve(lifted, np.zeros(3), rest, UP, DIRECT, motion.speed)
        raise GoalRefusedError(_blocked("the way back", goal.terrain, direct))


def lift(start: Vector, away: Vector, motion: Motion) -> Path:
    """Return the path of a foot off the ground: it stays in the air."""
    return Path((straight(start, start + motion.retreat_height * away, motion.speed),))


def at(point: Vector) -> Path:
    """Return a path that stays where it is."""
    return Path((straight(point, point, 1.0),))


def curve(
    start: Vector, velocity: Vector, end: Vector, arrival: Vector, bow: Bow, speed: float
) -> Leg:
    """Return a leg that leaves upwards, or as it moves, and arrives against the normal.

    Args:
        start: (3,) [m].
        velocity: (3,) at the start [m/s].
        end: (3,), above the surface [m].
        arrival: (3,) unit, from which the end is reached.
        bow: Drawn away from the direct curve.
        speed: Top speed [m/s].
    """
    way = end - start
    swing = min(0.3 * float(np.linalg.norm(way)), 0.1)
    pace = float(np.linalg.norm(velocity))
    leave = velocity / pace if pace > MOVING else UP
    flat = math.hypot(way[0], way[1])
    left = np.array([-way[1], way[0], 0.0]) / flat if flat > 1e-6 else np.zeros(3)
    detour = bow.up * UP + bow.side * left
    points = np.stack([start, start + swing * leave + detour, end + swing * arrival + detour, end])
    return make_leg(points, speed, velocity)


def _clearest(
    terrain: Terrain,
    start: Vector,
    velocity: Vector,
    end: Vector,
    arrival: Vector,
    motion: Motion,
    bows: Sequence[Bow],
    *,
    least: float = 0.0,
    home: bool = False,
) -> tuple[Leg, Bow, float]:
    """Return the first leg that clears the terrain by a margin, or the one that clears it most.

    Returns:
        The leg, its bow, and its margin [m]: negative where nothing clears.
    """
    shoulder = terrain.arm.shoulder
    ends = max(float(np.linalg.norm(start - shoulder)), float(np.linalg.norm(end - shoulder)))
    reach = max(terrain.arm.reach, ends + BOW_STEP)
    tried = []
    for bow in bows:
        leg = curve(start, velocity, end, arrival, bow, motion.speed)
        limit = np.inf if bow == DIRECT else reach
        margin, _ = terrain.margin(leg, home=home, reach=limit)
        tried.append((leg, bow, margin))
        if margin >= least:
            return tried[-1]
    return max(tried, key=lambda found: found[2])


def _planned(terrain: Terrain) -> Sequence[Bow]:
    """Return the bows to try: all, or the planned one and somewhat higher ones."""
    bow = terrain.planned
    if bow is None:
        return BOWS
    return [bow, replace(bow, up=bow.up + 0.5 * HIGHER), replace(bow, up=bow.up + HIGHER)]


def _blocked(what: str, terrain: Terrain, direct: Leg) -> str:
    """Return what is in the way of the direct leg, and how high the hand could go over it."""
    _, when = terrain.margin(direct)
    obstacle = find_obstacle(terrain, direct.position(when), terrain.clearance)
    if obstacle is None:
        return f"{what} leads too close to what stands beside it; choose another point"
    arm = terrain.arm
    flat = math.hypot(obstacle.x - arm.shoulder[0], obstacle.y - arm.shoulder[1])
    top = arm.shoulder[2] + math.sqrt(max(arm.reach**2 - flat**2, 0.0))
    over = top - arm.radius - terrain.clearance
    if over < obstacle.height:
        limit = f"the hand could go over it up to {over:.2f} m" if over > 0.0 else "it is too far"
    else:
        limit = f"no way over or around it keeps {100 * terrain.clearance:.0f} cm away"
    return f"{what} is blocked by {obstacle.text()}; {limit}. Take it away, or choose another point"


def _no_room(terrain: Terrain, target: Vector) -> str:
    """Return what stands too close to the target."""
    obstacle = find_obstacle(terrain, target, 0.0)
    found = obstacle.text() if obstacle else "something"
    return (
        f"there is no room for the hand at the point: {found} stands closer than its "
        f"{100 * terrain.arm.radius:.0f} cm. Choose a point farther from it"
    )
