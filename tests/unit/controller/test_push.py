"""Hands that push with a commanded force."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from fakes.contact_world import ContactWorld, make_goal
from w2c.messages import Array
from w2c_controller.kinematics.model import ControlledModel
from w2c_controller.parameters import RIGHT_HAND, Motion, Parameters
from w2c_controller.switching.contact_parameters import Push
from w2c_controller.switching.push import PushCommand

TABLE = 0.84
BOOK = (0.45, -0.30, TABLE)
DT = 0.002
MakeWorld = Callable[[], ContactWorld]


@pytest.fixture
def make_world(model: ControlledModel, joints: Array) -> MakeWorld:
    parameters = Parameters(motion=Motion(load_timeout=5.0))
    return lambda: ContactWorld(model, joints, {RIGHT_HAND: TABLE}, parameters)


def test_the_target_never_changes_faster_than_its_rate_and_arrives() -> None:
    push = Push()
    command = PushCommand(push, DT)
    command.reset(12.0)
    command.goal = 60.0
    targets = [12.0]
    for _ in range(round(8.0 / DT)):
        targets.append(command.step(targets[-1]))
    rates = np.diff(targets) / DT
    assert rates.max() <= push.rate + 1e-9
    assert np.abs(np.diff(rates)).max() <= push.acceleration * DT + 1e-9
    assert targets[-1] == pytest.approx(60.0, abs=0.05)
    assert max(targets) < 60.5


def test_the_target_waits_for_a_force_that_does_not_follow() -> None:
    push = Push()
    command = PushCommand(push, DT)
    command.reset(20.0)
    command.goal = 100.0
    for _ in range(round(5.0 / DT)):
        command.step(20.0)
    assert command.target == pytest.approx(20.0 + push.lead, abs=0.1)


def test_a_hand_pushes_with_the_force_that_was_commanded(make_world: MakeWorld) -> None:
    world = make_world()
    world.switching.place(make_goal(BOOK, force=60.0))
    assert world.run(40.0, "loaded") == "loaded"
    assert world.normal(RIGHT_HAND) == pytest.approx(60.0, abs=1.1)
    world.run(5.0)
    assert world.normal(RIGHT_HAND) == pytest.approx(60.0, abs=0.5)


def test_another_force_at_the_same_place_does_not_lift_the_hand(make_world: MakeWorld) -> None:
    world = make_world()
    world.switching.place(make_goal(BOOK, goal_id="first", force=50.0))
    assert world.run(40.0, "loaded") == "loaded"
    where = world.end_effectors.position(RIGHT_HAND)
    beside = (BOOK[0] + 0.01, BOOK[1], BOOK[2])
    world.switching.place(make_goal(beside, goal_id="second", force=25.0))
    assert world.run(20.0, "loaded") == "loaded"
    assert world.normal(RIGHT_HAND) == pytest.approx(25.0, abs=1.1)
    world.switching.place(make_goal(BOOK, goal_id="third"))
    assert world.run(20.0, "loaded") == "loaded"
    assert world.told()[-4:] == [
        ("second", "moving"),
        ("second", "loaded"),
        ("third", "moving"),
        ("third", "loaded"),
    ]
    assert not world.retargeting.state.pushing[RIGHT_HAND]
    world.run(6.0)
    assert world.normal(RIGHT_HAND) > 30.0  # its share again, as balance finds best
    assert "unload" not in world.phases
    assert np.linalg.norm(world.end_effectors.position(RIGHT_HAND) - where) < 2e-3


def test_another_place_does_lift_it(make_world: MakeWorld) -> None:
    world = make_world()
    world.switching.place(make_goal(BOOK, goal_id="first", force=30.0))
    world.run(40.0, "loaded")
    world.switching.place(make_goal((0.50, -0.25, TABLE), goal_id="second", force=30.0))
    assert world.run(60.0, "loaded") == "loaded"
    assert world.phases[4:8] == ["unload", "retreat", "approach", "touch"]
    assert world.normal(RIGHT_HAND) == pytest.approx(30.0, abs=1.1)


def test_a_force_that_limits_forbid_is_told_with_them_and_the_contact_stays(
    make_world: MakeWorld,
) -> None:
    world = make_world()
    world.switching.place(make_goal(BOOK, goal_id="lean"))
    world.run(30.0, "loaded")
    limits = world.retargeting.parameters.limits
    assert limits.hand_force_max == 150.0
    goal = replace(make_goal(BOOK, goal_id="hard"), force=400.0)  # admission would refuse it
    world.switching.place(goal)
    # As soon as the ramp stands still, not at the end of the 45 s that 400 N may take.
    assert world.run(25.0, "aborted") == "aborted"
    reason = world.events[-1].reason
    assert "did not take its load of 400 N" in reason
    assert "held back: " in reason
    world.run(2.0)
    assert world.retargeting.state.enabled[RIGHT_HAND]
    assert world.retargeting.failures == 0


def test_a_released_hand_pushes_no_more(make_world: MakeWorld) -> None:
    world = make_world()
    world.switching.place(make_goal(BOOK, force=30.0))
    world.run(40.0, "loaded")
    world.switching.release("r", RIGHT_HAND)
    assert not world.retargeting.state.pushing[RIGHT_HAND]
    assert world.run(30.0, "released") == "released"
    assert not world.retargeting.state.enabled[RIGHT_HAND]
    assert not world.retargeting.state.pushing[RIGHT_HAND]


def test_a_stop_keeps_the_force_that_is_there(make_world: MakeWorld) -> None:
    world = make_world()
    world.switching.place(make_goal(BOOK, force=100.0))
    world.run(30.0, "touched")
    world.run(4.0)
    world.switching.abort("stopped")
    force = world.normal(RIGHT_HAND)
    assert 20.0 < force < 60.0
    world.run(4.0)
    assert world.normal(RIGHT_HAND) == pytest.approx(force, abs=1.0)
