"""The way of a hand: continuous, within its speed, at rest where it should be."""

import numpy as np
import pytest

from w2c_controller.goals import Goal
from w2c_controller.parameters import Motion
from w2c_controller.routes import approach, retreat
from w2c_controller.trajectory import Path, curved, straight

DT = 0.002
UP = np.array([0.0, 0.0, 1.0])
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
    points = _walk(approach(_goal(task), start, Motion()))
    speeds = np.diff(points, axis=0) / DT
    np.testing.assert_allclose(points[0], start)
    assert np.linalg.norm(speeds, axis=1).max() <= 1.02 * Motion().speed
    assert np.linalg.norm(np.diff(speeds, axis=0), axis=1).max() / DT < 1.5
    assert np.linalg.norm(speeds[0]) < 1e-3
    assert np.linalg.norm(speeds[-1]) < 1e-3


def test_a_contact_is_approached_along_the_normal_and_searched_below_the_surface() -> None:
    goal = _goal("contact")
    path = approach(goal, np.array([0.27, -0.45, 0.95]), Motion())
    np.testing.assert_allclose(path.legs[1].points[0], goal.target + Motion().via_height * UP)
    np.testing.assert_allclose(path.end, goal.target - Motion().overtravel * UP)
    along = path.legs[1].position(path.legs[1].duration / 2) - goal.target
    np.testing.assert_allclose(along[:2], 0.0, atol=1e-12)
    late = path.legs[0].duration * 0.97
    heading = path.legs[0].points[3] - path.legs[0].position(late)
    assert -UP @ heading / np.linalg.norm(heading) > 0.99


def test_a_reach_stops_before_its_point() -> None:
    goal = _goal("reach")
    path = approach(goal, np.array([0.3, 0.4, 0.9]), Motion())
    assert np.linalg.norm(path.end - goal.target) == pytest.approx(Motion().reach_standoff)
    assert path.end[0] < goal.target[0]
    assert path.end[2] > goal.target[2]


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
    path = Path((curved(POINT, POINT + UP, UP, 0.1), straight(POINT + UP, POINT, 0.1)))
    assert not path.finished
    path.next_leg()
    assert path.leg == 1
    np.testing.assert_allclose(path.position(), POINT + UP)
    path.next_leg()
    assert path.leg == 1
