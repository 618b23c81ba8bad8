"""A point inside a rack: the hand comes down behind the rim, or the goal is refused."""

import math

import numpy as np
import pytest

from support.tabletop import CELL, ORIGIN
from w2c.errors import GoalRefusedError
from w2c.messages import Array, HeightField, PlaceGoal, RobotDescription
from w2c_controller.goals.goals import Goal, check_place
from w2c_controller.goals.planner import RoutePlanner
from w2c_controller.kinematics.model import Kinematics, build_model, standing_configuration
from w2c_controller.motion.grasp import FLATTEST
from w2c_controller.motion.terrain import NEAR_CLEARANCE, POINTING_RADIUS
from w2c_controller.parameters import LEFT_HAND, Motion

DOOR = 0.19
RIM_X, RIM_TOP = 1.01, 0.33
PLATE = (1.14, 0.14, 0.33)
"""A point on its front, which leans back by 18 degrees"""
NORMAL = (-math.cos(math.radians(18.0)), 0.0, math.sin(math.radians(18.0)))


def rack(rim_top: float) -> HeightField:
    """Return the open door of a dishwasher, the front rim of its rack, and a plate behind it."""
    heights = np.full((80, 100), np.nan, np.float32)
    rows = np.round((np.array([0.96, 1.45]) - ORIGIN[0]) / CELL).astype(int)
    columns = np.round((np.array([-0.16, 0.44]) - ORIGIN[1]) / CELL).astype(int)
    heights[rows[0] : rows[1], columns[0] : columns[1]] = DOOR
    rim = round((RIM_X - 0.5 * CELL - ORIGIN[0]) / CELL)
    heights[rim, columns[0] + 3 : columns[1] - 3] = rim_top
    across = slice(*np.round((np.array([0.04, 0.24]) - ORIGIN[1]) / CELL).astype(int))
    for x, height in ((1.11, 0.26), (1.13, 0.32), (1.15, 0.38), (1.17, 0.45)):
        heights[round((x - 0.5 * CELL - ORIGIN[0]) / CELL), across] = height
    return HeightField(stamp_ns=0, origin=ORIGIN, cell=CELL, heights=heights)


@pytest.fixture(scope="module")
def planned_for(description: RobotDescription) -> tuple[RoutePlanner, Array]:
    """A planner, and the posture of the robot that stands."""
    model = build_model(description)
    joints = np.array(description.initial_position)[model.joint_indices]
    posture = standing_configuration(model, joints)
    kinematics = Kinematics(model)
    kinematics.update_frames(posture)
    return RoutePlanner(model, kinematics, Motion()), posture


def the_goal() -> Goal:
    """Return the goal of the left hand at the plate."""
    message = PlaceGoal(
        goal_id="g",
        end_effector="left_hand",
        task="reach",
        point=np.array(PLATE),
        normal=np.array(NORMAL),
    )
    goal = check_place(message, (0.0, 0.05))
    assert goal.effector == LEFT_HAND
    return goal


def pitch(goal: Goal) -> float:
    """Return by how much the fingers point down [rad]."""
    return math.asin(-float(goal.fingers[2]))


def test_a_hand_comes_down_behind_the_rim_of_a_rack(
    planned_for: tuple[RoutePlanner, Array],
) -> None:
    planner, posture = planned_for
    goal = the_goal()
    planned = planner.plan(goal, rack(RIM_TOP), posture, leaves=False)
    assert pitch(goal) == pytest.approx(FLATTEST)
    assert pitch(planned) > FLATTEST + math.radians(5.0)
    # From the tips on, the hand is a cylinder behind its frame; the rim is a line across.
    rim = np.array([RIM_X + 0.5 * CELL, PLATE[1], RIM_TOP])
    via = planned.target - Motion().via_height * planned.fingers
    for hand in (via, planned.target):
        from_hand = rim - hand
        off = from_hand - (from_hand @ planned.fingers) * planned.fingers
        assert np.linalg.norm(off) >= POINTING_RADIUS
    assert np.linalg.norm(rim - via) >= POINTING_RADIUS + NEAR_CLEARANCE
    assert 0.02 <= (planned.target - np.array(PLATE)) @ np.array(NORMAL) <= 0.037 + 1e-9


def test_without_a_rim_the_hand_comes_as_it_likes(
    planned_for: tuple[RoutePlanner, Array],
) -> None:
    planner, posture = planned_for
    planned = planner.plan(the_goal(), rack(DOOR), posture, leaves=False)
    assert pitch(planned) == pytest.approx(FLATTEST)


def test_a_rim_that_is_too_high_is_named(planned_for: tuple[RoutePlanner, Array]) -> None:
    planner, posture = planned_for
    with pytest.raises(GoalRefusedError, match=r"blocked by something 0\.60 m high at x 1\.0"):
        planner.plan(the_goal(), rack(0.6), posture, leaves=False)
