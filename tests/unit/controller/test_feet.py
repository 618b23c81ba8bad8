"""Feet as goals: lifted, put down elsewhere, loaded; never without the others carrying."""

from collections.abc import Callable

import numpy as np
import pytest

from fakes.contact_world import ContactWorld, make_goal
from w2c.messages import Array
from w2c_controller.kinematics.model import ControlledModel
from w2c_controller.parameters import LEFT_FOOT, RIGHT_FOOT, RIGHT_HAND, Motion

TABLE = 0.84
BOOK = (0.45, -0.30, TABLE)
MakeWorld = Callable[[], ContactWorld]


@pytest.fixture
def make_world(model: ControlledModel, joints: Array) -> MakeWorld:
    return lambda: ContactWorld(model, joints, {RIGHT_HAND: TABLE})


def test_a_released_foot_is_unloaded_lifted_and_stays_in_the_air(make_world: MakeWorld) -> None:
    world = make_world()
    world.switching.release("lift", LEFT_FOOT)
    assert world.run(20.0, "released") == "released"
    assert world.phases == ["unload", "retreat", "hold"]
    assert world.retargeting.state.enabled == (False, True, False, False)
    world.run(3.0)
    foot = world.end_effectors.position(LEFT_FOOT)
    assert foot[2] == pytest.approx(Motion().foot_lift, abs=5e-3)
    assert np.linalg.norm(foot[:2] - [0.0, 0.085]) < 5e-3
    assert world.told() == [("lift", "released")]
    assert world.findings == []


def test_a_foot_in_contact_is_lifted_moved_put_down_and_loaded(make_world: MakeWorld) -> None:
    world = make_world()
    world.switching.place(make_goal((0.08, 0.10, 0.0), "left_foot", goal_id="step"))
    assert world.run(40.0, "loaded") == "loaded"
    assert world.phases == ["unload", "retreat", "approach", "touch", "load", "contact"]
    assert world.told() == [("step", state) for state in ("moving", "touched", "loaded")]
    world.run(5.0)
    np.testing.assert_allclose(
        world.end_effectors.position(LEFT_FOOT), [0.08, 0.10, 0.0], atol=5e-3
    )
    assert world.retargeting.state.enabled == (True, True, False, False)
    assert world.normal(LEFT_FOOT) > 300.0
    assert world.retargeting.failures == 0


def test_a_foot_is_a_support_only_where_it_felt_the_ground(make_world: MakeWorld) -> None:
    world = make_world()
    world.gone.add(LEFT_FOOT)
    world.switching.place(make_goal((0.05, 0.10, 0.0), "left_foot"))
    assert world.run(40.0, "aborted") == "aborted"
    assert "no surface" in world.events[-1].reason
    world.run(6.0)
    assert world.retargeting.state.enabled == (False, True, False, False)
    assert world.end_effectors.position(LEFT_FOOT)[2] > 0.01


def test_a_foot_comes_off_while_a_hand_leans(make_world: MakeWorld) -> None:
    world = make_world()
    world.switching.place(make_goal(BOOK, goal_id="lean"))
    assert world.run(30.0, "loaded") == "loaded"
    world.switching.release("lift", LEFT_FOOT)
    assert world.run(20.0, "released") == "released"
    assert world.retargeting.state.enabled == (False, True, False, True)
    assert world.retargeting.loaded(RIGHT_HAND)


def test_the_last_foot_is_kept_with_what_holds_it_back(make_world: MakeWorld) -> None:
    world = make_world()
    world.switching.place(make_goal(BOOK, goal_id="lean"))
    world.run(30.0, "loaded")
    world.switching.release("lift", LEFT_FOOT)
    world.run(20.0, "released")
    world.switching.release("jump", RIGHT_FOOT)
    assert world.run(40.0, "aborted") == "aborted"
    reason = world.events[-1].reason
    assert "cannot be taken off the right foot" in reason
    assert "held back: " in reason
    assert "150 N" in reason
    assert world.switching.phase == "hold"
    world.run(5.0)
    assert world.retargeting.state.enabled[RIGHT_FOOT]
    assert not world.retargeting.state.releasing[RIGHT_FOOT]


def test_a_foot_that_touches_something_on_its_way_stays_there(make_world: MakeWorld) -> None:
    world = make_world()
    world.switching.release("lift", LEFT_FOOT)
    world.run(20.0, "released")
    world.switching.place(make_goal((0.15, 0.12, 0.0), "left_foot", goal_id="step"))
    world.run(0.6)
    world.extra[LEFT_FOOT] = [-60.0, 0.0, 0.0]
    assert world.run(2.0, "aborted") == "aborted"
    assert "touched something" in world.events[-1].reason
    assert world.findings[-1].cause == "contact_unexpected"
    where = world.end_effectors.position(LEFT_FOOT)
    world.run(2.0)
    assert np.linalg.norm(world.end_effectors.position(LEFT_FOOT) - where) < 0.01
    assert not world.retargeting.state.enabled[LEFT_FOOT]
