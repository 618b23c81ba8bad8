"""Whether the contacts that are left would balance the robot, asked before one is taken away."""

import numpy as np
import pytest

from w2c.errors import GoalRefusedError
from w2c.messages import Array, EndEffector, PlaceGoal
from w2c_controller.kinematics.model import ControlledModel
from w2c_controller.parameters import LEFT_FOOT, LEFT_HAND, RIGHT_FOOT, RIGHT_HAND
from w2c_controller.preview.removal import check_removal, stays_there
from w2c_controller.preview.search import StaticSearch
from w2c_controller.seiko.desired import DesiredState

BOOK = np.array([0.48, -0.25, 0.84])
UP = np.array([0.0, 0.0, 1.0])


@pytest.fixture(scope="module")
def search(model: ControlledModel) -> StaticSearch:
    return StaticSearch(model)


@pytest.fixture
def leaning(search: StaticSearch, joints: Array) -> DesiredState:
    """On both feet, the right hand on a book."""
    search.start(joints)
    search.move(RIGHT_HAND, BOOK + 0.05 * UP)
    search.load(RIGHT_HAND, np.eye(3))
    return search.state.copy()


@pytest.fixture
def on_one_foot(search: StaticSearch, leaning: DesiredState) -> DesiredState:
    """On the left foot, the right hand on a book."""
    search.start_from(leaning)
    assert search.free(RIGHT_FOOT)
    return search.state.copy()


@pytest.mark.parametrize("contact", [LEFT_FOOT, RIGHT_FOOT, RIGHT_HAND, LEFT_HAND])
def test_one_of_two_feet_or_a_hand_may_be_taken_away(
    search: StaticSearch, leaning: DesiredState, contact: int
) -> None:
    check_removal(search, leaning, contact)


def test_a_hand_may_be_taken_away_on_one_foot(
    search: StaticSearch, on_one_foot: DesiredState
) -> None:
    check_removal(search, on_one_foot, RIGHT_HAND)


def test_the_last_foot_is_refused_with_what_stays_on_it_and_why(
    search: StaticSearch, on_one_foot: DesiredState
) -> None:
    before = on_one_foot.copy()
    with pytest.raises(GoalRefusedError) as refusal:
        check_removal(search, on_one_foot, LEFT_FOOT)
    text = str(refusal.value)
    assert "left foot cannot be taken off" in text
    assert "of 886 N stay on it" in text
    assert "because the left foot presses at the right" in text
    np.testing.assert_array_equal(on_one_foot.q, before.q)
    np.testing.assert_array_equal(on_one_foot.wrenches, before.wrenches)
    assert on_one_foot.enabled == before.enabled


@pytest.mark.parametrize(
    ("point", "end_effector", "stays"),
    [
        (BOOK, "right_hand", True),
        (BOOK + np.array([0.01, 0.0, 0.0]), "right_hand", True),
        (BOOK + np.array([0.03, 0.0, 0.0]), "right_hand", False),
        (np.array([0.0, 0.085, 0.0]), "left_foot", False),
    ],
)
def test_the_same_place_again_takes_nothing_away(
    search: StaticSearch,
    leaning: DesiredState,
    point: Array,
    end_effector: EndEffector,
    stays: bool,
) -> None:
    goal = PlaceGoal(goal_id="g", end_effector=end_effector, task="contact", point=point, normal=UP)
    assert stays_there(search, leaning, goal) is stays
