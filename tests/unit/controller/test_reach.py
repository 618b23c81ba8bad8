"""How far the hand gets, found without a robot: the window that a support opens."""

import numpy as np
import pytest

from w2c.errors import ControlError
from w2c.messages import PlaceGoal, RobotDescription
from w2c_controller.preview.reach import farthest_reach

UP = np.array([0.0, 0.0, 1.0])


def _support(x: float) -> PlaceGoal:
    return PlaceGoal(
        goal_id="s",
        end_effector="right_hand",
        task="contact",
        point=np.array([x, -0.25, 0.84]),
        normal=UP,
    )


def _reach(description: RobotDescription, support: PlaceGoal | None) -> float:
    return farthest_reach(
        description,
        end_effector="left_hand",
        origin=(0.0, 0.15),
        height=0.9,
        direction=(1.0, 0.0),
        support=support,
    )


def test_a_support_makes_a_window(description: RobotDescription) -> None:
    on_two_feet, leaning = _reach(description, None), _reach(description, _support(0.48))
    assert 1.0 < on_two_feet < 1.2
    assert leaning - on_two_feet > 0.08


def test_a_support_out_of_reach_is_an_error(description: RobotDescription) -> None:
    with pytest.raises(ControlError, match="cannot be reached"):
        _reach(description, _support(1.5))


def test_feet_do_not_reach(description: RobotDescription) -> None:
    with pytest.raises(ControlError):
        farthest_reach(
            description, end_effector="left_foot", origin=(0, 0), height=0.5, direction=(1, 0)
        )


def test_a_ray_beyond_the_arm_is_not_reached_at_all(description: RobotDescription) -> None:
    reach = farthest_reach(
        description, end_effector="left_hand", origin=(0.0, 0.15), height=2.1, direction=(1.0, 0.0)
    )
    assert reach == 0.0
