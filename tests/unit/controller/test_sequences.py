"""Goals one after another: new words during a motion, both hands, and back again."""

from collections.abc import Callable

import numpy as np
import pytest

from fakes.contact_world import ContactWorld, make_goal
from w2c.messages import Array
from w2c_controller.kinematics.model import ControlledModel
from w2c_controller.parameters import LEFT_HAND, RIGHT_HAND, Filters

TABLE = 0.84
RIGHT_BOOK = (0.45, -0.30, TABLE)
LEFT_BOOK = (0.45, 0.30, TABLE)
A_BIT_TO_THE_LEFT = (0.45, -0.24, TABLE)
MakeWorld = Callable[[], ContactWorld]


@pytest.fixture
def make_world(model: ControlledModel, joints: Array) -> MakeWorld:
    return lambda: ContactWorld(model, joints, {LEFT_HAND: TABLE, RIGHT_HAND: TABLE})


def run_until_phase(world: ContactWorld, phase: str) -> None:
    for _ in range(3000):
        if world.switching.phase == phase:
            return
        world.run(world.dt)
    raise AssertionError(f"never in phase {phase}")


@pytest.mark.parametrize("after", [0.8, 1.5, 2.5])
def test_a_bit_to_the_left_while_the_hand_moves_bends_the_way(
    make_world: MakeWorld, after: float
) -> None:
    world = make_world()
    world.switching.place(make_goal(RIGHT_BOOK, goal_id="there"))
    world.run(after)
    assert world.switching.phase == "approach"
    goal = make_goal(A_BIT_TO_THE_LEFT, goal_id="left")
    speed = world.end_effectors.speed(RIGHT_HAND)
    velocity = world.end_effectors.velocity(RIGHT_HAND)
    world.switching.place(goal)
    slowest, distances = speed, [world.switching.distance()]
    for tick in range(100):
        world.run(world.dt)
        change = world.end_effectors.velocity(RIGHT_HAND) - velocity
        velocity = velocity + change
        assert np.abs(change).max() < 2.0 * Filters().acceleration * world.dt
        if tick < 40:
            slowest = min(slowest, world.end_effectors.speed(RIGHT_HAND))
        distances.append(world.switching.distance())
    # It neither stops nor turns back.
    assert slowest > 0.4 * speed
    assert np.diff(distances).max() < 1e-3
    assert world.run(30.0, "loaded") == "loaded"
    assert world.told()[:3] == [("there", "moving"), ("there", "aborted"), ("left", "moving")]
    target = np.array(A_BIT_TO_THE_LEFT)
    assert np.linalg.norm(world.end_effectors.position(RIGHT_HAND)[:2] - target[:2]) < 0.01


def test_a_new_goal_while_the_hand_feels_for_the_surface(make_world: MakeWorld) -> None:
    world = make_world()
    world.switching.place(make_goal(RIGHT_BOOK, goal_id="there"))
    run_until_phase(world, "touch")
    world.run(0.6)
    world.switching.place(make_goal(A_BIT_TO_THE_LEFT, goal_id="left"))
    assert world.run(30.0, "loaded") == "loaded"
    assert world.events[-1].goal_id == "left"
    assert world.phases == ["approach", "touch", "approach", "touch", "load", "contact"]


def test_a_new_goal_while_the_hand_takes_load_lifts_it_first(make_world: MakeWorld) -> None:
    world = make_world()
    world.switching.place(make_goal(RIGHT_BOOK, goal_id="there"))
    run_until_phase(world, "load")
    world.run(0.3)
    world.switching.place(make_goal((0.45, -0.20, TABLE), goal_id="left"))
    assert world.run(40.0, "loaded") == "loaded"
    assert world.events[-1].goal_id == "left"
    assert world.phases[3:6] == ["unload", "retreat", "approach"]
    told = [event for event in world.events if event.goal_id == "there"]
    assert [event.state for event in told] == ["moving", "touched", "aborted"]


def test_a_new_goal_while_the_hand_comes_back(make_world: MakeWorld) -> None:
    world = make_world()
    world.switching.place(make_goal(RIGHT_BOOK, goal_id="there"))
    world.run(30.0, "loaded")
    world.switching.release("back", RIGHT_HAND)
    run_until_phase(world, "retreat")
    world.run(1.0)
    world.switching.place(make_goal(A_BIT_TO_THE_LEFT, goal_id="again"))
    assert world.run(30.0, "loaded") == "loaded"
    assert ("back", "aborted") in world.told()
    assert world.events[-1].goal_id == "again"


def test_both_hands_lean_one_after_the_other_and_leave_again(make_world: MakeWorld) -> None:
    world = make_world()
    enabled = []
    steps: list[Callable[[], None]] = [
        lambda: world.switching.place(make_goal(LEFT_BOOK, "left_hand", goal_id="1")),
        lambda: world.switching.place(make_goal(RIGHT_BOOK, goal_id="2")),
        lambda: world.switching.release("3", LEFT_HAND),
        lambda: world.switching.place(make_goal(LEFT_BOOK, "left_hand", goal_id="4")),
        lambda: world.switching.release("5", RIGHT_HAND),
        lambda: world.switching.release("6", LEFT_HAND),
    ]
    for number, step in enumerate(steps):
        step()
        state = "released" if number in (2, 4, 5) else "loaded"
        assert world.run(60.0, state) == state
        assert world.events[-1].goal_id == str(number + 1)
        enabled.append(world.retargeting.state.enabled[2:])
    assert enabled == [
        (True, False),
        (True, True),
        (False, True),
        (True, True),
        (True, False),
        (False, False),
    ]
    assert world.retargeting.failures == 0
    assert world.findings == []
