"""What a goal must be before anything moves; a refusal says value, limit and what to do."""

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from w2c.errors import GeometryError, GoalRefusedError
from w2c.geometry import unit
from w2c.messages import EndEffector, PlaceGoal, Task
from w2c_controller.motion.grasp import REACH_STANDOFF, approach_direction, standoff
from w2c_controller.motion.terrain import Terrain
from w2c_controller.parameters import EFFECTORS, FEET, HANDS, Limits

Vector = npt.NDArray[np.float64]

FARTHEST = 2.0
"""From the robot's axis [m]: no arm with any support gets there."""
HIGHEST = 2.2
"""[m]"""
BODY_RADIUS = 0.18
"""Of the cylinder around the robot's axis that is the robot itself [m]."""
BEHIND = -0.1
"""Points with a smaller x are behind the robot [m]."""
DOWNWARD = -0.2
"""A surface whose normal has a smaller z cannot be leaned on from above."""
LONGEST_STEP = 0.6
"""From the robot's axis [m]."""
HIGHEST_STEP = 0.4
"""[m]"""
STEEPEST_GROUND = math.radians(20.0)
"""For a foot: the ankle must turn as far."""
SAME_NORMAL = math.cos(math.radians(15.0))
"""A goal whose normal differs less is at the same surface."""
NOMINAL = Limits()


@dataclass(frozen=True)
class Goal:
    """A goal that was checked."""

    goal_id: str
    end_effector: EndEffector
    task: Task
    point: Vector
    """(3,) on the surface, in the world [m]"""
    normal: Vector
    """(3,) unit"""
    target: Vector
    """(3,) where the frame of the end effector shall be [m]: where it touches the point, or a
    little off the surface, for a reach"""
    force: float = 0.0
    """Normal force to push with [N]; 0: its share, as balance finds best"""
    steeper: float = 0.0
    """That the fingers of a reaching hand point down more than they would [rad]"""
    terrain: Terrain | None = None
    """What the way must clear; None: nothing is known of it"""

    @property
    def effector(self) -> int:
        """Index of the end effector."""
        return EFFECTORS.index(self.end_effector)

    @property
    def fingers(self) -> Vector:
        """Direction (3,) in which a reaching hand points."""
        return approach_direction(self.point, self.normal, self.steeper)

    def is_at(self, position: Vector, normal: Vector, within: float) -> bool:
        """Return whether a contact at a position (3,) with a normal (3,) is what is asked for."""
        off = float(np.linalg.norm(self.target - position))
        return off < within and float(self.normal @ normal) > SAME_NORMAL


def check_end_effector(name: str) -> int:
    """Return the index of an end effector. Raises GoalRefusedError for a name that is none."""
    if name not in EFFECTORS:
        raise GoalRefusedError(
            f"end effector '{name}' is unknown; choose one of {', '.join(EFFECTORS)}"
        )
    return EFFECTORS.index(name)


def check_place(
    message: PlaceGoal, hand_radius: tuple[float, float], limits: Limits = NOMINAL
) -> Goal:
    """Return the goal of a message. Raises GoalRefusedError with the reason."""
    effector = check_end_effector(message.end_effector)
    point = np.array(message.point, dtype=np.float64)
    if point.shape != (3,) or not np.isfinite(point).all():
        raise GoalRefusedError(f"point {message.point} is not three finite numbers [m]")
    if message.task not in ("contact", "reach"):
        raise GoalRefusedError(f"task '{message.task}' is unknown; choose contact or reach")
    try:
        normal = unit(message.normal)
    except GeometryError as error:
        raise GoalRefusedError(f"normal: {error}; give the direction out of the surface") from error
    if effector in FEET:
        _check_step(message, point, normal)
    else:
        _check_point(point)
        _check_surface(message, normal)
    radius = hand_radius[effector - HANDS[0]] if effector in HANDS else 0.0
    goal = Goal(
        goal_id=message.goal_id,
        end_effector=message.end_effector,
        task=message.task,
        point=point,
        normal=normal,
        target=point + radius * normal,
        force=_checked_force(message, effector, limits),
    )
    return goal if message.task == "contact" else pointed(goal, radius)


def pointed(goal: Goal, radius: float, steeper: float = 0.0) -> Goal:
    """Return the goal of a reaching hand whose fingers point down more than they would.

    Args:
        goal: Of a hand.
        radius: Of the ball that the hand is; 0: it is open, with fingers [m].
        steeper: [rad]
    """
    goal = replace(goal, steeper=steeper)
    off = radius + REACH_STANDOFF if radius > 0.0 else standoff(goal.fingers, goal.normal)
    return replace(goal, target=goal.point + off * goal.normal)


def _checked_force(message: PlaceGoal, effector: int, limits: Limits) -> float:
    """Return the commanded normal force [N]; 0 where none is."""
    force = float(message.force)
    if force == 0.0:
        return 0.0
    if effector in FEET or message.task != "contact":
        raise GoalRefusedError(
            f"force {force:g} N: only a hand in contact pushes with a force of its own; leave it 0"
        )
    least, most = limits.hand_force_min, limits.hand_force_max
    if not least <= force <= most:
        raise GoalRefusedError(
            f"force {force:g} N is outside {least:g} to {most:g} N; 0 leaves it to balance"
        )
    return force


def _check_surface(message: PlaceGoal, normal: Vector) -> None:
    """Refuse surfaces that a hand cannot lean on."""
    if message.task == "contact" and normal[2] < DOWNWARD:
        raise GoalRefusedError(
            f"the surface faces down (normal z {normal[2]:.2f}, limit {DOWNWARD}): "
            "a hand cannot lean on it"
        )


def _check_step(message: PlaceGoal, point: Vector, normal: Vector) -> None:
    """Refuse what a foot cannot stand on."""
    if message.task != "contact":
        raise GoalRefusedError("a foot stands, it does not reach; choose contact, or a hand")
    from_axis = float(np.hypot(point[0], point[1]))
    if from_axis > LONGEST_STEP:
        raise GoalRefusedError(
            f"the point is {from_axis:.2f} m away, limit {LONGEST_STEP} m for a foot"
        )
    if not 0.0 <= point[2] <= HIGHEST_STEP:
        raise GoalRefusedError(
            f"the point is {point[2]:.2f} m high, limit 0 to {HIGHEST_STEP} m for a foot"
        )
    slope = math.acos(min(max(float(normal[2]), -1.0), 1.0))
    if slope > STEEPEST_GROUND:
        raise GoalRefusedError(
            f"the ground slopes by {math.degrees(slope):.0f} degrees, limit "
            f"{math.degrees(STEEPEST_GROUND):.0f} degrees for a foot"
        )


def _check_point(point: Vector) -> None:
    """Refuse points that no motion of the arms can mean."""
    x, _, z = (float(value) for value in point)
    from_axis = float(np.hypot(point[0], point[1]))
    if z < 0.0:
        raise GoalRefusedError(f"the point is {-z:.2f} m below the floor")
    if z > HIGHEST:
        raise GoalRefusedError(f"the point is {z:.2f} m high, limit {HIGHEST} m")
    if from_axis < BODY_RADIUS:
        raise GoalRefusedError(
            f"the point is inside the robot: {from_axis:.2f} m from its axis, "
            f"at least {BODY_RADIUS} m needed"
        )
    if x < BEHIND:
        raise GoalRefusedError(
            f"the point is {-x:.2f} m behind the robot; the arms work in front of it"
        )
    if from_axis > FARTHEST:
        raise GoalRefusedError(
            f"the point is {from_axis:.2f} m away, limit {FARTHEST} m; bring the robot closer"
        )
