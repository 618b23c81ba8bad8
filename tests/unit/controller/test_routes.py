"""Ways clear what the camera saw by five centimetres, or are refused with what blocks them."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from support.tabletop import CELL, ORIGIN, TABLE, table
from w2c.errors import GoalRefusedError
from w2c.messages import HeightField, Task
from w2c_controller.goals.goals import Goal
from w2c_controller.motion.routes import (
    approach,
    check_retreat,
    may_cut,
    plan_approach,
    retreat,
    way_back,
)
from w2c_controller.motion.terrain import (
    ARM_BALLS,
    ARM_SPACING,
    FULL_CLEARANCE,
    NEAR_CLEARANCE,
    NEAR_TARGET,
    OBJECT_RADIUS,
    SURFACE_TOLERANCE,
    SURROUNDINGS,
    Arm,
    make_terrain,
)
from w2c_controller.motion.trajectory import Leg
from w2c_controller.parameters import Motion

UP = np.array([0.0, 0.0, 1.0])
AT_REST = np.zeros(3)
START = np.array([0.25, -0.40, 1.0])
ARM = Arm(
    radius=0.06,
    elbow=np.array([-0.08, -0.45, 1.15]),
    shoulder=np.array([-0.03, -0.29, 1.37]),
    reach=0.95,
)


def goal_at(
    x: float, y: float, field: HeightField | None, task: Task = "contact", z: float = TABLE
) -> Goal:
    """Return a goal of the right hand on a level surface."""
    point = np.array([x, y, z])
    terrain = (
        make_terrain(field, ARM, point, UP, Motion().clearance, reach=task == "reach")
        if field is not None
        else None
    )
    return Goal(
        goal_id="g",
        end_effector="right_hand",
        task=task,
        point=point,
        normal=UP,
        target=point + 0.05 * UP,
        terrain=terrain,
    )


def distances(leg: Leg, field: HeightField, goal: Goal) -> list[float]:
    """Return how far hand and forearm are from obstacles all along a leg, beyond clearance [m].

    By brute force over the cells of what stands on the table, and some of the table, each a box
    of full width, without the grown floors of the planner. What is not higher than
    the surface of the target around it does not count.
    """
    rows, columns = np.nonzero(np.isfinite(field.heights))
    kept = (field.heights[rows, columns] > TABLE) | ((rows % 3 == 0) & (columns % 3 == 0))
    rows, columns = rows[kept], columns[kept]
    low = np.column_stack([ORIGIN[0] + CELL * rows, ORIGIN[1] + CELL * columns])
    tops = field.heights[rows, columns].astype(np.float64)
    away = np.linalg.norm(low + CELL / 2 - goal.point[:2], axis=1)
    surface = (away < SURROUNDINGS) & (tops < goal.point[2] + SURFACE_TOLERANCE + 0.5 * CELL)
    if goal.task == "reach":
        surface |= away < OBJECT_RADIUS
    low, tops, away = low[~surface], tops[~surface], away[~surface]
    clearance = np.where(
        away < FULL_CLEARANCE, 0.5 * (NEAR_CLEARANCE + Motion().clearance), Motion().clearance
    )
    clearance[away < NEAR_TARGET] = NEAR_CLEARANCE
    found = []
    for time in np.linspace(0.0, leg.duration, 50):
        hand = leg.position(time)
        towards = (ARM.elbow - hand) / np.linalg.norm(ARM.elbow - hand)
        for ball in range(ARM_BALLS):
            centre = hand + ball * ARM_SPACING * towards
            flat = np.maximum(np.maximum(low - centre[:2], centre[:2] - low - CELL), 0.0)
            drop = np.maximum(centre[2] - tops, 0.0)
            gaps = np.sqrt((flat**2).sum(axis=1) + drop**2)
            found.append(float((gaps - clearance).min(initial=np.inf)) - ARM.radius)
    return found


boxes = st.lists(
    st.tuples(
        st.floats(0.4, 1.0),
        st.floats(-0.8, 0.2),
        st.floats(0.04, 0.3),
        st.floats(0.04, 0.3),
        st.floats(TABLE + 0.03, 1.4),
    ),
    max_size=4,
)


@settings(max_examples=40)
@given(boxes=boxes, x=st.floats(0.45, 0.9), y=st.floats(-0.7, 0.0), reach=st.booleans())
def test_a_way_clears_everything_by_five_centimetres_or_is_refused(
    boxes: list[tuple[float, float, float, float, float]], x: float, y: float, reach: bool
) -> None:
    field = table(*boxes)
    goal = goal_at(x, y, field, "reach" if reach else "contact")
    try:
        path = approach(goal, START, AT_REST, Motion())
    except GoalRefusedError:
        return
    at_start = distances(Leg(np.tile(START, (4, 1)), 1.0), field, goal)
    if min(at_start) < CELL:
        return  # it begins too close: it may come clear on the way
    assert min(distances(path.legs[0], field, goal)) >= 0.0


@settings(max_examples=20)
@given(boxes=boxes)
def test_a_way_back_clears_everything_or_its_goal_is_refused(
    boxes: list[tuple[float, float, float, float, float]],
) -> None:
    field = table(*boxes)
    goal = goal_at(0.6, -0.3, field)
    try:
        check_retreat(goal, START, Motion())
    except GoalRefusedError:
        return
    path = retreat(goal.target, way_back(goal), START, Motion(), None, goal.terrain)
    lifted = goal.target + Motion().retreat_height * UP
    if min(distances(Leg(np.tile(lifted, (4, 1)), 1.0), field, goal)) < CELL:
        return
    assert min(distances(path.legs[1], field, goal)) >= 0.0


def test_an_empty_table_bows_no_way() -> None:
    with_field = approach(goal_at(0.6, -0.3, table()), START, AT_REST, Motion())
    without = approach(goal_at(0.6, -0.3, None), START, AT_REST, Motion())
    np.testing.assert_array_equal(with_field.legs[0].points, without.legs[0].points)


def test_a_way_bows_over_a_box() -> None:
    field = table((0.46, -0.35, 0.06, 0.2, 0.93))
    goal = goal_at(0.9, -0.3, field)
    path = approach(goal, START, AT_REST, Motion())
    direct = approach(goal_at(0.9, -0.3, None), START, AT_REST, Motion()).legs[0]
    assert path.legs[0].points[1, 2] > direct.points[1, 2]
    assert min(distances(direct, field, goal)) < 0.0
    assert min(distances(path.legs[0], field, goal)) >= 0.0


def test_a_way_back_bows_over_a_box() -> None:
    field = table((0.46, -0.35, 0.06, 0.2, 1.02))
    goal = goal_at(0.95, -0.3, field, "reach", z=0.98)
    bowed = retreat(goal.target, UP, START, Motion(), None, goal.terrain).legs[1]
    direct = retreat(goal.target, UP, START, Motion(), None, None).legs[1]
    assert bowed.points[1, 2] > direct.points[1, 2]
    assert min(distances(bowed, field, goal)) >= 0.0
    assert min(distances(direct, field, goal)) < 0.0


def test_the_forearm_must_clear_too() -> None:
    """The hand could pass over this box, but at the point the forearm would lie on it."""
    field = table((0.5, -0.34, 0.08, 0.2, 1.0))
    with pytest.raises(GoalRefusedError, match=r"1\.00 m high at x 0\.50"):
        approach(goal_at(0.75, -0.3, field), START, AT_REST, Motion())


def test_a_wall_is_refused_with_its_place_height_and_size() -> None:
    field = table((0.55, -0.3, 0.1, 1.4, 2.1))
    with pytest.raises(GoalRefusedError) as refused:
        approach(goal_at(0.8, -0.3, field), START, AT_REST, Motion())
    text = str(refused.value)
    assert "2.10 m high at x 0.55, y -0.30 m (0.10 x 1.40 m)" in text
    assert "could go over it up to" in text
    assert "Take it away" in text


def test_a_thing_beside_the_point_leaves_no_room_for_the_hand() -> None:
    field = table((0.66, -0.3, 0.04, 0.04, 0.84))
    with pytest.raises(GoalRefusedError, match="no room for the hand"):
        approach(goal_at(0.6, -0.3, field), START, AT_REST, Motion())


def test_what_is_reached_for_is_no_obstacle_to_itself() -> None:
    cup = (0.7, -0.3, 0.08, 0.08, 0.9)
    path = approach(goal_at(0.7, -0.3, table(cup), "reach", z=0.9), START, AT_REST, Motion())
    assert path.leg == 0


def test_unseen_cells_block_nothing() -> None:
    nothing = HeightField(
        stamp_ns=0, origin=ORIGIN, cell=CELL, heights=np.full((80, 100), np.nan, np.float32)
    )
    with_field = approach(goal_at(0.6, -0.3, nothing), START, AT_REST, Motion())
    without = approach(goal_at(0.6, -0.3, None), START, AT_REST, Motion())
    np.testing.assert_array_equal(with_field.legs[0].points, without.legs[0].points)


def test_a_hand_that_starts_beside_a_thing_may_leave_it() -> None:
    field = table((0.4, -0.4, 0.04, 0.1, 1.02))
    path = approach(goal_at(0.6, -0.1, field), START, AT_REST, Motion())
    late = distances(path.legs[0], field, goal_at(0.6, -0.1, field))[-40:]
    assert min(late) >= 0.0


def test_a_hand_must_come_back_whatever_stands_there() -> None:
    field = table((0.45, -0.3, 0.06, 1.4, 1.9))
    goal = goal_at(0.7, -0.3, field)
    path = retreat(goal.target, UP, START, Motion(), None, goal.terrain)
    np.testing.assert_allclose(path.end, START)
    with pytest.raises(GoalRefusedError, match="the way back is blocked"):
        check_retreat(goal, START, Motion())


def test_a_floor_grows_as_a_ball_over_an_edge() -> None:
    field = table((0.7, -0.3, 0.02, 0.02, 1.0))
    terrain = goal_at(0.5, 0.4, field).terrain
    assert terrain is not None
    row, column = round((0.7 - 0.1) / CELL), round((-0.3 + 1.0) / CELL)
    radius = ARM.radius + Motion().clearance
    for steps in range(8):
        expected = math.sqrt(max(radius**2 - (max(steps - 1, 0) * CELL) ** 2, 0.0))
        floor = terrain.travel_floor[row, column + steps]
        assert floor == pytest.approx(
            max(1.0 + expected, TABLE + radius) if expected else TABLE + radius
        )


def test_a_wall_can_be_leaned_on() -> None:
    """Everything behind the plane of the target belongs to the surface, however high."""
    field = table((0.75, -0.3, 0.1, 1.4, 1.6))
    point, normal = np.array([0.7, -0.3, 1.1]), np.array([-1.0, 0.0, 0.0])
    goal = Goal(
        goal_id="g",
        end_effector="right_hand",
        task="contact",
        point=point,
        normal=normal,
        target=point + 0.05 * normal,
        terrain=make_terrain(field, ARM, point, normal, 0.05, reach=False),
    )
    path = approach(goal, START, AT_REST, Motion())
    assert path.end[0] > point[0] - 0.05


def test_a_planned_way_needs_no_search_when_the_hand_sets_out() -> None:
    """From where it was planned and from a little beside, it is the planned bow."""
    field = table((0.46, -0.35, 0.06, 0.2, 0.93))
    goal = plan_approach(goal_at(0.9, -0.3, field), START, Motion())
    assert goal.terrain is not None
    assert goal.terrain.planned is not None
    for beside in ([0.0, 0.0, 0.0], [0.005, -0.005, 0.0], [0.0, 0.005, 0.005]):
        start = START + np.array(beside)
        leg = approach(goal, start, AT_REST, Motion()).legs[0]
        np.testing.assert_allclose(leg.points[1, 2] - start[2], 0.1 + goal.terrain.planned.up)
        assert min(distances(leg, field, goal)) >= 0.0


def test_a_hand_that_is_elsewhere_when_it_sets_out_does_not_go_through_things() -> None:
    field = table((0.5, -0.3, 0.06, 0.6, 1.15))
    goal = plan_approach(goal_at(0.45, 0.3, field), np.array([0.3, 0.4, 1.0]), Motion())
    with pytest.raises(GoalRefusedError, match="blocked"):
        approach(goal, np.array([0.75, -0.45, 0.95]), AT_REST, Motion())


@pytest.mark.parametrize(("height", "may"), [(TABLE + 0.02, True), (TABLE + 0.5, False)])
def test_a_stuck_hand_goes_straight_to_its_point_only_where_that_is_clear(
    height: float, may: bool
) -> None:
    goal = goal_at(0.9, -0.4, table((0.6, -0.4, 0.06, 0.3, height)), "reach", TABLE + 0.3)
    before_the_box = np.array([0.35, -0.4, TABLE + 0.3])
    assert may_cut(goal.terrain, before_the_box, goal.target, Motion()) is may
    assert may_cut(None, before_the_box, goal.target, Motion())
