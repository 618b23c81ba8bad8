"""Goals that are refused, each with its reason; nothing moves."""

import msgspec
import numpy as np
import pytest
from msgspec.structs import replace

from w2c.errors import GoalRefusedError
from w2c.messages import Array, EndEffector, PlaceGoal, ReleaseGoal, Task
from w2c_controller.goals.body import Body
from w2c_controller.goals.goals import check_end_effector, check_place
from w2c_controller.goals.requests import Requests, Situation
from w2c_controller.kinematics.model import ControlledModel, Kinematics, standing_configuration

RADIUS = (0.0, 0.05)


def _place(
    *,
    point: tuple[float, float, float] = (0.5, -0.25, 0.84),
    normal: tuple[float, float, float] = (0.0, 0.0, 1.0),
    hand: EndEffector = "right_hand",
    task: Task = "contact",
    effective_tick: int = -1,
    goal_id: str = "g",
    force: float = 0.0,
) -> PlaceGoal:
    return PlaceGoal(
        goal_id=goal_id,
        end_effector=hand,
        task=task,
        point=np.array(point),
        normal=np.array(normal),
        effective_tick=effective_tick,
        force=max(force, 0.0),
    )


def _step(
    *,
    point: tuple[float, float, float] = (0.15, 0.1, 0.0),
    normal: tuple[float, float, float] = (0.0, 0.0, 1.0),
    task: Task = "contact",
    force: float = 0.0,
) -> PlaceGoal:
    return _place(point=point, normal=normal, hand="left_foot", task=task, force=force)


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


def test_a_ball_that_reaches_stops_two_centimetres_off_the_surface() -> None:
    goal = check_place(_place(task="reach"), RADIUS)
    np.testing.assert_allclose(goal.target, [0.5, -0.25, 0.84 + 0.05 + 0.02])
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
        (_broken(force=-1.0), "outside 10 to 150 N"),
        (_broken(force=float("nan")), "outside 10 to 150 N"),
        (_place(force=5.0), "outside 10 to 150 N"),
        (_place(force=200.0), "outside 10 to 150 N"),
        (_place(force=50.0, task="reach"), "hand in contact"),
        (_step(force=50.0), "hand in contact"),
        (_step(task="reach"), "a foot stands"),
        (_step(point=(0.8, 0.1, 0.0)), "limit 0.6 m for a foot"),
        (_step(point=(0.2, 0.1, 0.5)), "limit 0 to 0.4 m"),
        (_step(normal=(0.5, 0.0, 0.8)), "limit 20 degrees"),
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


def test_a_goal_that_comes_again_is_refused() -> None:
    requests = Requests(RADIUS)
    requests.situation = READY
    requests.place(_place())
    with pytest.raises(GoalRefusedError, match="taken already"):
        requests.place(_place())
    with pytest.raises(GoalRefusedError, match="taken already"):
        requests.release(ReleaseGoal(goal_id="g", end_effector="right_hand"))
    assert len(requests.due(10**9)) == 1


@pytest.mark.parametrize("leaning", [False, True])
def test_the_only_foot_on_the_ground_stays(leaning: bool) -> None:
    requests = Requests(RADIUS)
    requests.situation = replace(READY, enabled=(True, False, leaning, False))
    with pytest.raises(GoalRefusedError, match="150 N each" if leaning else "no one"):
        requests.release(ReleaseGoal(goal_id="r", end_effector="left_foot"))
    with pytest.raises(GoalRefusedError, match="only foot"):
        requests.place(_step())
    with pytest.raises(GoalRefusedError, match="in the air already"):
        requests.release(ReleaseGoal(goal_id="r", end_effector="right_foot"))


def test_one_of_two_feet_may_be_lifted_or_placed() -> None:
    requests = Requests(RADIUS)
    requests.situation = READY
    requests.release(ReleaseGoal(goal_id="r", end_effector="left_foot"))
    requests.place(_step())
    assert [request.effector for request in requests.due(10**9)] == [0, 0]


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


@pytest.mark.parametrize(
    ("goal", "part"),
    [
        (_place(point=(0.13, 0.14, 0.42)), "left leg"),
        (_place(point=(0.25, 0.40, 1.03)), "left arm"),
        (_place(point=(0.22, 0.02, 1.25)), "trunk"),
        (_step(point=(0.05, -0.01, 0.0)), "right foot"),
    ],
)
def test_points_inside_the_robot_are_refused(
    model: ControlledModel, joints: Array, goal: PlaceGoal, part: str
) -> None:
    bowing = joints.copy()
    bowing[model.joint_names.index("torso_2_joint")] += 0.5 if part == "trunk" else 0.0
    q = standing_configuration(model, bowing)
    requests = Requests(RADIUS, body=Body(model))
    requests.situation = replace(READY, desired=(0, q))
    with pytest.raises(GoalRefusedError, match=f"inside the robot: .* cm within the {part}"):
        requests.place(goal)
    assert requests.due(10**9) == []


def test_points_beside_the_robot_are_taken(model: ControlledModel, joints: Array) -> None:
    q = standing_configuration(model, joints)
    requests = Requests(RADIUS, body=Body(model))
    requests.situation = replace(READY, desired=(0, q))
    # Its own arm does not count: it will have moved away.
    x, y, z = _hand(model, q).tolist()
    for number, point in enumerate([(0.5, -0.25, 0.84), (0.3, 0.0, 0.8), (x, y, z)]):
        requests.place(_place(point=point, goal_id=str(number)))


def _hand(model: ControlledModel, q: Array) -> Array:
    kinematics = Kinematics(model)
    kinematics.update_frames(q)
    return np.array(kinematics.positions[3])


def test_a_hand_at_rest_cannot_be_released() -> None:
    requests = Requests(RADIUS)
    requests.situation = replace(READY, away=(True, False))
    with pytest.raises(GoalRefusedError, match="at rest"):
        requests.release(ReleaseGoal(goal_id="r", end_effector="right_hand"))
    requests.release(ReleaseGoal(goal_id="r", end_effector="left_hand"))
