"""A goal with a height field, from its admission to the motion: over it, or not at all."""

import msgspec
import numpy as np
import pytest

from fakes.ideal_robot import IdealRobot
from support.tabletop import TABLE, table
from w2c.errors import GoalRefusedError
from w2c.messages import Array, HeightField, PlaceGoal, ReleaseGoal, RobotDescription
from w2c_controller.controller import Controller
from w2c_controller.parameters import LEFT_HAND, Parameters
from w2c_controller.seiko.force_parameters import ForceParameters

WALL = table((0.62, 0.3, 0.04, 1.0, 2.1))
BOX = (0.62, 0.34, 0.06, 0.12, 1.01)


@pytest.fixture
def slow_description(description: RobotDescription) -> RobotDescription:
    """A robot with ticks of 10 ms: five times faster tests."""
    return msgspec.structs.replace(description, period_ns=10_000_000)


@pytest.fixture
def robot(slow_description: RobotDescription) -> IdealRobot:
    return IdealRobot(slow_description)


def make_controller(description: RobotDescription) -> Controller:
    """Return one that commands the desired posture, which is where an ideal robot's joints are."""
    return Controller(description, Parameters(force_control=ForceParameters(mode="off")))


@pytest.fixture
def controller(slow_description: RobotDescription) -> Controller:
    return make_controller(slow_description)


def _goal(
    goal_id: str, point: tuple[float, float, float], obstacles: HeightField | None
) -> PlaceGoal:
    return PlaceGoal(
        goal_id=goal_id,
        end_effector="left_hand",
        task="reach",
        point=np.array(point),
        normal=np.array([0.0, 0.0, 1.0]),
        obstacles=obstacles,
    )


def _hand(controller: Controller) -> Array:
    return np.array(controller.retargeting.kinematics.positions[LEFT_HAND])


def _gap(position: Array, box: tuple[float, float, float, float, float]) -> float:
    """Return the distance of a point from a box on the table [m]."""
    x, y, length, width, top = box
    flat = np.maximum(np.abs(position[:2] - [x, y]) - [length / 2, width / 2], 0.0)
    return float(np.hypot(np.linalg.norm(flat), max(position[2] - top, 0.0)))


def _run(controller: Controller, robot: IdealRobot, until: str, gaps: list[float]) -> list[str]:
    """Run until an event, at most 25 s; notes the gap between hand and box at each tick."""
    states: list[str] = []
    for _ in range(2500):
        robot.step(controller)
        gaps.append(_gap(_hand(controller), BOX))
        states += [event.state for event in controller.take_events()]
        if until in states or "aborted" in states:
            break
    return states


def test_a_blocked_way_is_refused_and_the_robot_does_not_move_by_a_bit(
    controller: Controller, robot: IdealRobot, slow_description: RobotDescription
) -> None:
    undisturbed, twin = IdealRobot(slow_description), make_controller(slow_description)
    robot.step(controller, 250)
    undisturbed.step(twin, 250)
    with pytest.raises(GoalRefusedError) as refused:
        controller.requests.place(_goal("g", (0.85, 0.3, TABLE + 0.1), WALL))
    assert "blocked by something 2.10 m high at x 0.62, y 0.30 m" in str(refused.value)
    assert "could go over it up to" in str(refused.value)
    for _ in range(20):
        np.testing.assert_array_equal(
            robot.step(controller).position, undisturbed.step(twin).position
        )
    assert not controller.take_events()


def test_a_hand_goes_over_a_box_and_back(controller: Controller, robot: IdealRobot) -> None:
    robot.step(controller, 250)
    controller.requests.place(_goal("g", (0.98, 0.3, TABLE + 0.25), table(BOX)))
    gaps: list[float] = []
    assert "reached" in _run(controller, robot, "reached", gaps)
    controller.requests.release(ReleaseGoal(goal_id="r", end_effector="left_hand"))
    assert "released" in _run(controller, robot, "released", gaps)
    assert min(gaps) >= 0.05 + 0.06 - 0.01, "five centimetres beyond the hand, less its lag"


def test_without_a_height_field_the_same_way_is_direct(
    controller: Controller, robot: IdealRobot
) -> None:
    robot.step(controller, 250)
    controller.requests.place(_goal("g", (0.98, 0.3, TABLE + 0.25), None))
    gaps = []
    for _ in range(1500):
        robot.step(controller)
        gaps.append(_gap(_hand(controller), BOX))
    assert min(gaps) < 0.05 + 0.06 - 0.01


def test_a_target_that_moves_is_followed_without_a_stop(
    controller: Controller, robot: IdealRobot
) -> None:
    """The operator says "a bit to the left" while the hand is on its way."""
    robot.step(controller, 250)
    controller.requests.place(_goal("g", (0.75, 0.3, TABLE + 0.2), table()))
    positions = []
    for tick in range(400):
        robot.step(controller)
        positions.append(_hand(controller))
        if tick == 150:
            controller.requests.place(_goal("h", (0.75, 0.4, TABLE + 0.2), table()))
    velocities = np.diff(np.array(positions), axis=0) / 0.01
    speeds = np.linalg.norm(velocities, axis=1)
    changes = np.linalg.norm(np.diff(velocities, axis=0), axis=1) / 0.01
    assert speeds[145] > 0.05
    assert speeds[150:200].min() > 0.4 * speeds[145]
    assert changes[140:260].max() < 1.5
    assert np.linalg.norm(positions[-1] - positions[150]) > 0.1
