"""The way of a hand: continuous, within its speed, at rest where it should be."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from w2c_controller.goals.goals import Goal
from w2c_controller.motion.routes import DIRECT, approach, curve, retreat
from w2c_controller.motion.trajectory import Path, make_leg, straight
from w2c_controller.parameters import Motion

DT = 0.002
UP = np.array([0.0, 0.0, 1.0])
AT_REST = np.zeros(3)
POINT = np.array([0.5, -0.25, 0.84])


def _goal(task: str) -> Goal:
    return Goal(
        goal_id="g",
        end_effector="right_hand",
        task="contact" if task == "contact" else "reach",
        point=POINT,
        normal=UP,
        target=POINT + 0.05 * UP,
    )


def _walk(path: Path) -> np.ndarray:
    points = [path.position()]
    while not path.finished:
        path.advance(DT)
        points.append(path.position())
    return np.array(points)


@pytest.mark.parametrize("task", ["contact", "reach"])
def test_an_approach_is_continuous_in_position_and_speed(task: str) -> None:
    start = np.array([0.27, -0.45, 0.95])
    points = _walk(approach(_goal(task), start, AT_REST, Motion()))
    speeds = np.diff(points, axis=0) / DT
    np.testing.assert_allclose(points[0], start)
    assert np.linalg.norm(speeds, axis=1).max() <= 1.02 * Motion().speed
    assert np.linalg.norm(np.diff(speeds, axis=0), axis=1).max() / DT < 1.5
    assert np.linalg.norm(speeds[0]) < 1e-3
    assert np.linalg.norm(speeds[-1]) < 1e-3


def test_a_contact_is_approached_along_the_normal_and_searched_below_the_surface() -> None:
    goal = _goal("contact")
    path = approach(goal, np.array([0.27, -0.45, 0.95]), AT_REST, Motion())
    np.testing.assert_allclose(path.legs[1].points[0], goal.target + Motion().via_height * UP)
    np.testing.assert_allclose(path.end, goal.target - Motion().overtravel * UP)
    along = path.legs[1].position(path.legs[1].duration / 2) - goal.target
    np.testing.assert_allclose(along[:2], 0.0, atol=1e-12)
    late = path.legs[0].duration * 0.97
    heading = path.legs[0].points[3] - path.legs[0].position(late)
    assert -UP @ heading / np.linalg.norm(heading) > 0.99


def test_a_reach_ends_at_its_target_and_comes_along_the_fingers() -> None:
    goal = _goal("reach")
    path = approach(goal, np.array([0.3, 0.4, 0.9]), AT_REST, Motion())
    np.testing.assert_allclose(path.end, goal.target)
    via = goal.target - Motion().via_height * goal.fingers
    np.testing.assert_allclose(path.legs[1].points[0], via)
    assert via[0] < goal.target[0]
    assert via[2] > goal.target[2]


def test_a_retreat_goes_away_from_the_surface_first() -> None:
    rest = np.array([0.27, -0.45, 0.95])
    path = retreat(POINT, UP, rest, Motion())
    np.testing.assert_allclose(path.legs[0].points[3], POINT + Motion().retreat_height * UP)
    np.testing.assert_allclose(path.end, rest)


def test_a_leg_of_no_length_has_a_duration() -> None:
    leg = straight(POINT, POINT, 0.1)
    assert leg.duration > 0
    np.testing.assert_allclose(leg.position(0.05), POINT)


def test_a_path_waits_when_it_is_not_advanced_and_can_skip_a_leg() -> None:
    first = curve(POINT, AT_REST, POINT + UP, UP, DIRECT, 0.1)
    path = Path((first, straight(POINT + UP, POINT, 0.1)))
    assert not path.finished
    path.next_leg()
    assert path.leg == 1
    np.testing.assert_allclose(path.position(), POINT + UP)
    path.next_leg()
    assert path.leg == 1


coordinates = st.floats(-1.0, 1.0)
points = st.tuples(coordinates, coordinates, coordinates).map(np.array)
velocities = st.tuples(*[st.floats(-0.12, 0.12)] * 3).map(np.array)


@given(start=points, end=points, velocity=velocities, share=st.floats(0.01, 0.99))
def test_the_velocity_of_a_leg_is_the_difference_of_its_positions(
    start: np.ndarray, end: np.ndarray, velocity: np.ndarray, share: float
) -> None:
    leg = curve(start, velocity, end, UP, DIRECT, 0.18)
    time, step = share * leg.duration, 1e-6
    difference = (leg.position(time + step) - leg.position(time - step)) / (2 * step)
    np.testing.assert_allclose(leg.velocity(time), difference, atol=1e-5)
    np.testing.assert_array_equal(leg.velocity(leg.duration + 0.1), 0.0)


@given(start=points, end=points, velocity=velocities)
def test_a_leg_begins_with_the_velocity_of_the_hand_and_ends_at_rest(
    start: np.ndarray, end: np.ndarray, velocity: np.ndarray
) -> None:
    leg = curve(start, velocity, end, UP, DIRECT, 0.18)
    step = 1e-6
    beginning = (leg.position(step) - leg.position(0.0)) / step
    ending = (leg.position(leg.duration) - leg.position(leg.duration - step)) / step
    np.testing.assert_allclose(leg.position(0.0), start, atol=1e-12)
    np.testing.assert_allclose(beginning, velocity, atol=1e-4)
    np.testing.assert_allclose(leg.velocity(0.0), velocity, atol=1e-12)
    np.testing.assert_allclose(leg.position(leg.duration), end, atol=1e-12)
    np.testing.assert_allclose(ending, 0.0, atol=1e-4)


@given(start=points, end=points, velocity=velocities)
def test_a_leg_keeps_its_speed_and_does_not_jerk(
    start: np.ndarray, end: np.ndarray, velocity: np.ndarray
) -> None:
    leg = curve(start, velocity, end, UP, DIRECT, 0.18)
    step = leg.duration / 200
    positions = np.array([leg.position(n * step) for n in range(201)])
    speeds = np.linalg.norm(np.diff(positions, axis=0), axis=1) / step
    assert speeds.max() <= 1.001 * 0.18 + np.linalg.norm(velocity)
    accelerations = np.linalg.norm(np.diff(positions, 2, axis=0), axis=1) / step**2
    assert accelerations.max() < 5.0


def test_a_goal_that_changes_on_the_way_is_followed_without_a_jump_of_velocity() -> None:
    """Halfway to one point the goal moves ten centimetres to the left, as an operator says."""
    old = approach(_goal("contact"), np.array([0.27, -0.45, 0.95]), AT_REST, Motion())
    leg = old.legs[0]
    when = 0.45 * leg.duration
    before = leg.velocity(when)
    assert np.linalg.norm(before) > 0.1
    moved = replace(_goal("contact"), target=_goal("contact").target + np.array([0.0, 0.1, 0.0]))
    new = approach(moved, leg.position(when), before, Motion())
    np.testing.assert_allclose(new.position(), leg.position(when), atol=1e-12)
    np.testing.assert_allclose(new.velocity(), before, atol=1e-12)
    slowest = min(
        float(np.linalg.norm(new.legs[0].velocity(time)))
        for time in np.linspace(1e-4, 0.3 * new.legs[0].duration, 50)
    )
    assert slowest > 0.3 * np.linalg.norm(before), "it goes on, it does not stop and start again"


def test_a_leg_against_the_motion_turns_round_within_a_hand_width() -> None:
    start, velocity = np.zeros(3), np.array([0.18, 0.0, 0.0])
    leg = curve(start, velocity, np.array([-0.5, 0.0, 0.0]), UP, DIRECT, 0.18)
    farthest = max(leg.position(time)[0] for time in np.linspace(0.0, leg.duration, 200))
    assert 0.0 < farthest < 0.08


def test_a_leg_of_no_length_with_a_velocity_comes_to_rest() -> None:
    leg = make_leg(np.tile(POINT, (4, 1)), 0.18, np.array([0.1, 0.0, 0.0]))
    np.testing.assert_allclose(leg.position(leg.duration), POINT, atol=1e-12)
    np.testing.assert_allclose(leg.velocity(0.0), [0.1, 0.0, 0.0])
