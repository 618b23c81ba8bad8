"""Goals that are refused, each with its reason; nothing moves."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from w2c.errors import GoalRefusedError
from w2c.messages import EndEffector, PlaceGoal, ReleaseGoal, Task
from w2c_controller.goals import check_end_effector, check_place
from w2c_controller.requests import Requests, Situation

RADIUS = (0.0, 0.05)


def _place(
    *,
    point: tuple[float, float, float] = (0.5, -0.25, 0.84),
    normal: tuple[float, float, float] = (0.0, 0.0, 1.0),
    hand: EndEffector = "right_hand",
    task: Task = "contact",
    effective_tick: int = -1,
    goal_id: str = "g",
) -> PlaceGoal:
    return PlaceGoal(
        goal_id=goal_id,
        end_effector=hand,
        task=task,
        point=np.array(point),
        normal=np.array(normal),
        effective_tick=effective_tick,
    )


def _broken(**changes: object) -> PlaceGoal:
    """Return a goal that no bus would let through: the controller does not rely on it."""
    goal = _place()
    for name, value in changes.items():
        msgspec.structs.force_setattr(goal, name, value)
    return goal


def test_the_target_is_the_radius_above_the_surface() -> None:
    goal = check_place(_place(normal=(0.0, 0.0, 2.0)), RADIUS)
    np.testing.assert_allclose(goal.target, [0.5, -0.25, 0.89])
    np.testing.assert_allclose(goal.normal, [0.0, 0.0, 1.0])
    assert goal.effector == 3


@pytest.mark.parametrize(
    ("goal", "reason"),
    [
        (_broken(point=np.array([np.nan, 0.0, 1.0])), "finite"),
        (_broken(point=np.zeros(2)), "finite"),
        (_broken(normal=np.zeros(3)), "normal"),
        (_broken(normal=np.array([np.nan, 0.0, 1.0])), "normal"),
        (_broken(end_effector="tail"), "unknown"),
        (_broken(task="dance"), "unknown"),
        (_place(hand="left_foot"), "stays where it is"),
        (_place(point=(0.05, 0.0, 0.8)), "inside the robot"),
        (_place(point=(-0.5, 0.3, 0.8)), "behind"),
        (_place(point=(3.0, 0.0, 0.8)), "limit 2.0 m"),
        (_place(point=(0.5, 0.0, -0.2)), "below the floor"),
        (_place(point=(0.5, 0.0, 2.6)), "2.60 m high"),
        (_place(normal=(0.0, 0.0, -1.0)), "faces down"),
    ],
)
def test_refused_goals_say_why(goal: PlaceGoal, reason: str) -> None:
    with pytest.raises(GoalRefusedError, match=reason):
        check_place(goal, RADIUS)


def test_a_surface_that_faces_down_may_be_reached_for() -> None:
    assert check_place(_place(normal=(0.0, 0.0, -1.0), task="reach"), RADIUS).task == "reach"


def test_an_unknown_end_effector_is_named() -> None:
    with pytest.raises(GoalRefusedError, match="'tail'"):
        check_end_effector("tail")


READY = Situation(tick=100, ready=True)


@pytest.mark.parametrize(
    ("situation", "goal", "reason"),
    [
        (Situation(), _place(), "no state"),
        (replace(READY, stopped=True), _place(), "stopped"),
        (replace(READY, stale=True), _place(), "stale"),
        (READY, _place(effective_tick=100), "has passed"),
        (READY, _place(effective_tick=1_000_000), "ahead"),
        (replace(READY, busy_id="first", busy_effector=2), _place(), "'first'"),
    ],
)
def test_goals_at_a_wrong_time_are_refused(
    situation: Situation, goal: PlaceGoal, reason: str
) -> None:
    requests = Requests(RADIUS)
    requests.situation = situation
    with pytest.raises(GoalRefusedError, match=reason):
        requests.place(goal)
    assert requests.due(10**9) == []


def test_the_hand_that_moves_may_get_another_target() -> None:
    requests = Requests(RADIUS)
    requests.situation = replace(READY, busy_id="first", busy_effector=3)
    assert requests.place(_place()).start_tick == 101


def test_two_goals_at_once_are_refused_for_two_hands() -> None:
    requests = Requests(RADIUS)
    requests.situation = READY
    requests.place(_place(goal_id="a"))
    with pytest.raises(GoalRefusedError, match="'a'"):
        requests.place(_place(goal_id="b", hand="left_hand"))


def test_a_goal_waits_for_its_tick() -> None:
    requests = Requests(RADIUS)
    requests.situation = READY
    assert requests.place(_place(effective_tick=105)).start_tick == 105
    assert requests.due(104) == []
    assert [request.goal_id for request in requests.due(105)] == ["g"]
    assert requests.due(106) == []


def test_a_hand_at_rest_cannot_be_released() -> None:
    requests = Requests(RADIUS)
    requests.situation = replace(READY, away=(True, False))
    with pytest.raises(GoalRefusedError, match="at rest"):
        requests.release(ReleaseGoal(goal_id="r", end_effector="right_hand"))
    requests.release(ReleaseGoal(goal_id="r", end_effector="left_hand"))
