"""Goals that are refused: each with its reason, and the commands do not change by a bit."""

from collections.abc import Callable

import msgspec
import numpy as np
import pytest

from fakes.ideal_robot import IdealRobot
from w2c.errors import GoalRefusedError
from w2c.messages import EndEffector, PlaceGoal, ReleaseGoal, RobotDescription
from w2c_controller.controller import Controller

UP = np.array([0.0, 0.0, 1.0])
MOVING = 60
"""Ticks after which the left hand is under way."""


def reach(goal_id: str, **changes: object) -> PlaceGoal:
    """Return a goal of the left hand; what no bus would let through may be put into it."""
    goal = PlaceGoal(
        goal_id=goal_id,
        end_effector="left_hand",
        task="reach",
        point=np.array([0.7, 0.3, 0.95]),
        normal=UP,
    )
    for name, value in changes.items():
        msgspec.structs.force_setattr(goal, name, value)
    return goal


def lean(goal_id: str, end_effector: EndEffector = "right_hand") -> PlaceGoal:
    return reach(
        goal_id, end_effector=end_effector, task="contact", point=np.array([0.5, -0.25, 0.84])
    )


REFUSED: dict[str, tuple[Callable[[int], PlaceGoal | ReleaseGoal], str]] = {
    "point not finite": (
        lambda _: reach("bad", point=np.array([np.nan, 0.3, 0.9])),
        "not three finite numbers",
    ),
    "unknown end effector": (lambda _: reach("bad", end_effector="tail"), "'tail' is unknown"),
    "normal of length zero": (lambda _: reach("bad", normal=np.zeros(3)), "normal: "),
    "normal not finite": (lambda _: reach("bad", normal=np.full(3, np.inf)), "normal: "),
    "unknown task": (lambda _: reach("bad", task="dance"), "'dance' is unknown"),
    "inside the robot": (
        lambda _: reach("bad", point=np.array([0.13, 0.14, 0.42])),
        "within the right leg|within the left leg|inside the robot",
    ),
    "inside the other arm": (
        lambda _: reach("bad", point=np.array([0.1, -0.42, 1.04])),
        "within the right arm .radius 6 cm.",
    ),
    "out of range": (lambda _: reach("bad", point=np.array([3.0, 0.3, 0.9])), "limit 2.0 m"),
    "below the floor": (lambda _: reach("bad", point=np.array([0.5, 0.3, -0.1])), "0.10 m below"),
    "behind": (lambda _: reach("bad", point=np.array([-0.5, 0.3, 0.9])), "behind"),
    "second end effector": (lambda _: lean("bad"), "left hand is on its way .goal 'first'."),
    "a foot meanwhile": (
        lambda _: ReleaseGoal(goal_id="bad", end_effector="left_foot"),
        "left hand is on its way",
    ),
    "replayed": (lambda _: reach("first"), "'first' was taken already"),
    "in the past": (lambda tick: reach("bad", effective_tick=tick - 1), "has passed"),
    "far ahead": (lambda tick: reach("bad", effective_tick=tick + 40_000), "limit 30000"),
    "too much force": (
        lambda _: reach("bad", task="contact", force=151.0),
        "outside 10 to 150 N",
    ),
    "a foot too far": (
        lambda _: reach("bad", end_effector="left_foot", task="contact"),
        "limit 0.6 m for a foot",
    ),
    "at rest": (
        lambda _: ReleaseGoal(goal_id="bad", end_effector="right_hand"),
        "left hand is on its way|at rest",
    ),
}


@pytest.fixture(scope="module")
def slow(description: RobotDescription) -> RobotDescription:
    """A robot with ticks of 10 ms: five times faster tests."""
    return msgspec.structs.replace(description, period_ns=10_000_000)


def commands(
    description: RobotDescription, meanwhile: Callable[[Controller, IdealRobot], None] | None
) -> bytes:
    """Return the commands of a hand under way, with or without a call in between."""
    robot, controller = IdealRobot(description), Controller(description)
    robot.step(controller, 5)
    controller.requests.place(reach("first"))
    answers = [robot.step(controller).position for _ in range(MOVING)]
    if meanwhile is not None:
        meanwhile(controller, robot)
    answers += [robot.step(controller).position for _ in range(MOVING)]
    return np.stack(answers).tobytes()


def ask(controller: Controller, message: PlaceGoal | ReleaseGoal) -> None:
    if isinstance(message, PlaceGoal):
        controller.requests.place(message)
    else:
        controller.requests.release(message)


def test_refused_goals_do_not_change_the_commands_by_a_bit(slow: RobotDescription) -> None:
    undisturbed = commands(slow, None)

    def ask_all(controller: Controller, robot: IdealRobot) -> None:
        for make, reason in REFUSED.values():
            message = make(robot.tick)
            with pytest.raises(GoalRefusedError, match=reason):
                ask(controller, message)

    assert commands(slow, ask_all) == undisturbed


def test_a_goal_that_is_taken_does_change_them(slow: RobotDescription) -> None:
    def place(controller: Controller, _: IdealRobot) -> None:
        controller.requests.place(reach("second", point=np.array([0.6, 0.2, 1.0])))

    assert commands(slow, place) != commands(slow, None)


def test_goals_during_a_stop_are_refused_and_the_robot_holds(slow: RobotDescription) -> None:
    robot, controller = IdealRobot(slow), Controller(slow)
    robot.step(controller, 5)
    controller.requests.place(reach("first"))
    robot.step(controller, MOVING)
    controller.freeze("test")
    held = robot.step(controller).position
    for goal in (reach("during"), lean("other")):
        with pytest.raises(GoalRefusedError, match="stop"):
            controller.requests.place(goal)
    with pytest.raises(GoalRefusedError, match="stop"):
        controller.requests.release(ReleaseGoal(goal_id="r", end_effector="left_hand"))
    for _ in range(MOVING):
        np.testing.assert_array_equal(robot.step(controller).position, held)


def test_goals_are_refused_while_states_do_not_come(slow: RobotDescription) -> None:
    robot, controller = IdealRobot(slow), Controller(slow)
    robot.step(controller, 5)
    controller.set_stale(True)
    with pytest.raises(GoalRefusedError, match="stale"):
        controller.requests.place(reach("late"))
