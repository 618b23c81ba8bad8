"""Contacts that do not hold: lost, slipping, overloaded, or met where none should be."""

import copy
from collections.abc import Callable

import numpy as np
import pytest

from fakes.contact_world import ContactWorld, make_goal
from w2c.messages import Array
from w2c_controller.kinematics.model import ControlledModel
from w2c_controller.parameters import LEFT_FOOT, LEFT_HAND, RIGHT_FOOT, RIGHT_HAND
from w2c_controller.switching.contact_parameters import Supervision

TABLE = 0.84
BOOK = (0.45, -0.30, TABLE)
CUP = (1.3, 0.2, 0.95)
"""Out of reach: the left hand is under way for long."""
LIMITS = Supervision()
ALONG = np.array([1.0, 0.0, 0.0])
RADIUS = 0.05
"""Of the ball [m]."""


@pytest.fixture(scope="module")
def leaning_once(model: ControlledModel, joints: Array) -> ContactWorld:
    """The right hand leans, the left is on its way to a cup."""
    world = ContactWorld(model, joints, {RIGHT_HAND: TABLE})
    world.switching.place(make_goal(BOOK, goal_id="lean"))
    assert world.run(30.0, "loaded") == "loaded"
    world.run(2.0)
    world.switching.place(make_goal(CUP, "left_hand", task="reach", goal_id="cup"))
    world.run(1.5)
    assert world.findings == []
    return world


@pytest.fixture
def leaning(leaning_once: ContactWorld, model: ControlledModel) -> ContactWorld:
    """A copy for each test to spoil."""
    return copy.deepcopy(leaning_once, {id(model): model})


def rotation_about_y(angle: float) -> Array:
    """Return a rotation (3, 3); a ball on a table that turns so rolls along x."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def seconds_until(world: ContactWorld, done: Callable[[], bool], limit: float) -> float:
    """Run until something is so; returns the time it took [s]."""
    for tick in range(round(limit / world.dt)):
        if done():
            return tick * world.dt
        world.run(world.dt)
    raise AssertionError(f"not within {limit} s")


def hurry(world: ContactWorld) -> float:
    """Return how much sooner than 20 N the load of the right hand is missed."""
    return world.normal(RIGHT_HAND) / LIMITS.lost_desired[1]


def test_a_hand_that_lost_its_support_is_unloaded_and_the_robot_holds(
    leaning: ContactWorld,
) -> None:
    where, haste = leaning.end_effectors.position(RIGHT_HAND), hurry(leaning)
    assert haste > 1.5
    leaning.gone.add(RIGHT_HAND)
    waited = seconds_until(leaning, lambda: bool(leaning.findings), 1.0)
    assert waited == pytest.approx(LIMITS.lost_time / haste, abs=0.02)
    assert [finding.cause for finding in leaning.findings] == ["contact_lost"]
    leaning.run(0.02)
    assert leaning.told()[-2:] == [("lean", "aborted"), ("cup", "aborted")]
    assert "right hand lost its support" in leaning.events[-1].reason
    free = seconds_until(leaning, lambda: not leaning.retargeting.state.enabled[RIGHT_HAND], 15.0)
    assert free < 0.5  # a robot whose support went falls while it unloads as ever
    leaning.run(3.0)
    assert leaning.switching.phase == "hold"
    assert np.linalg.norm(leaning.end_effectors.position(RIGHT_HAND) - where) < 0.02
    assert leaning.retargeting.failures == 0
    assert len(leaning.findings) == 1


def test_what_is_found_next_does_not_keep_a_hand_without_support(leaning: ContactWorld) -> None:
    leaning.gone.add(RIGHT_HAND)
    seconds_until(leaning, lambda: bool(leaning.findings), 1.0)
    leaning.run(0.02)
    told = leaning.told()
    leaning.switching.abort("the right foot slips")
    leaning.run(leaning.dt)
    assert leaning.phases[-1] == "unload"
    seconds_until(leaning, lambda: not leaning.retargeting.state.enabled[RIGHT_HAND], 0.5)
    leaning.run(0.1)
    assert leaning.phases[-1] == "hold"
    assert leaning.told() == told


def test_the_goal_of_a_contact_ends_when_its_support_is_lost(
    model: ControlledModel, joints: Array
) -> None:
    world = ContactWorld(model, joints, {RIGHT_HAND: TABLE})
    world.switching.place(make_goal(BOOK, goal_id="lean"))
    assert world.run(30.0, "loaded") == "loaded"
    world.run(2.0)
    world.gone.add(RIGHT_HAND)
    world.run(1.0)
    assert world.told()[-1] == ("lean", "aborted")
    assert [state for _, state in world.told()].count("aborted") == 1


def test_a_lost_foot_holds_and_stays_a_contact(leaning: ContactWorld) -> None:
    leaning.gone.add(LEFT_FOOT)
    leaning.run(0.5)
    assert [(found.cause, found.effector) for found in leaning.findings] == [
        ("contact_lost", LEFT_FOOT)
    ]
    assert leaning.told()[-1] == ("cup", "aborted")
    leaning.run(3.0)
    assert leaning.retargeting.state.enabled == (True, True, False, True)
    assert leaning.switching.phase == "hold"


def test_a_short_loss_is_none(leaning: ContactWorld) -> None:
    leaning.gone.add(RIGHT_HAND)
    leaning.run(LIMITS.lost_time / hurry(leaning) - 0.03)
    leaning.gone.clear()
    leaning.run(1.0)
    assert leaning.findings == []
    assert leaning.switching.busy_with() == "cup"


@pytest.mark.parametrize("effector", [RIGHT_HAND, LEFT_FOOT, RIGHT_FOOT])
def test_a_slip_is_found_within_a_fifth_of_a_second_and_stops_the_motion(
    leaning: ContactWorld, effector: int
) -> None:
    begun = len(leaning.events)
    for _ in range(round(0.2 / leaning.dt)):
        leaning.moved[effector] += 0.05 * leaning.dt * ALONG  # 5 cm/s
        leaning.run(leaning.dt)
    causes = [finding.cause for finding in leaning.findings]
    assert causes == ["contact_slips"]
    # Which of two feet slips is the one that carries less.
    slipping = leaning.findings[0].effector
    assert (slipping == RIGHT_HAND) == (effector == RIGHT_HAND)
    assert "slips" in leaning.findings[0].text()
    leaning.run(0.05)
    assert [event.goal_id for event in leaning.events[begun:]] == ["cup"]
    assert leaning.switching.phase == "hold"
    assert leaning.retargeting.state.enabled == (True, True, False, True)


@pytest.mark.parametrize("effector", [LEFT_FOOT, RIGHT_HAND])
def test_only_a_slipping_foot_lets_a_hand_come_back(leaning: ContactWorld, effector: int) -> None:
    leaning.switching.release("back", LEFT_HAND)
    leaning.run(0.1)
    assert leaning.switching.phase == "retreat"
    for _ in range(round(0.2 / leaning.dt)):
        leaning.moved[effector] += 0.05 * leaning.dt * ALONG
        leaning.run(leaning.dt)
    assert [finding.cause for finding in leaning.findings] == ["contact_slips"]
    leaning.run(10.0)
    assert leaning.told()[-1] == ("back", "released" if effector == LEFT_FOOT else "aborted")


def test_a_foot_that_slips_far_is_not_taken_for_the_hand(leaning: ContactWorld) -> None:
    for _ in range(round(0.5 / leaning.dt)):
        leaning.moved[LEFT_FOOT] += 0.05 * leaning.dt * ALONG
        leaning.run(leaning.dt)
    assert {finding.effector for finding in leaning.findings} <= {LEFT_FOOT, RIGHT_FOOT}


def test_slow_creep_is_no_slip(leaning: ContactWorld) -> None:
    for _ in range(round(6.0 / leaning.dt)):
        leaning.moved[RIGHT_HAND] += 0.0005 * leaning.dt * ALONG
        leaning.run(leaning.dt)
    assert leaning.findings == []


def test_a_hand_that_is_drawn_slowly_over_its_friction_slips(leaning: ContactWorld) -> None:
    for _ in range(round(3.0 / leaning.dt)):
        leaning.moved[RIGHT_HAND] += 0.002 * leaning.dt * ALONG
        leaning.run(leaning.dt)
    assert [finding.cause for finding in leaning.findings] == ["contact_slips"]
    assert 0.004 < np.linalg.norm(leaning.moved[RIGHT_HAND]) < 0.009


@pytest.mark.parametrize("rolls", [True, False])
def test_a_ball_that_rolls_does_not_slip_and_one_that_turns_on_the_spot_does(
    leaning: ContactWorld, rolls: bool
) -> None:
    for tick in range(round(1.0 / leaning.dt)):
        angle = 0.3 * (tick + 1) * leaning.dt
        leaning.turned[1] = rotation_about_y(angle)
        leaning.moved[RIGHT_HAND] = RADIUS * angle * ALONG if rolls else 0.0
        leaning.run(leaning.dt)
    assert bool(leaning.findings) != rolls


def test_a_hand_that_slipped_bears_along_the_normal_alone(leaning: ContactWorld) -> None:
    leaning.retargeting.state.wrenches[RIGHT_HAND, 0] = 5.0
    leaning.run(0.1)
    along = leaning.retargeting.state.wrenches[RIGHT_HAND]
    assert np.hypot(along[0], along[1]) > 2.0
    normal = along[2]
    for _ in range(round(0.2 / leaning.dt)):
        leaning.moved[RIGHT_HAND] += 0.05 * leaning.dt * ALONG
        leaning.run(leaning.dt)
    leaning.run(2.0)
    along = leaning.retargeting.state.wrenches[RIGHT_HAND]
    assert np.hypot(along[0], along[1]) < 0.3
    assert along[2] == pytest.approx(normal, abs=5.0)
    assert leaning.retargeting.failures == 0


def test_a_hand_that_slips_again_is_unloaded(leaning: ContactWorld) -> None:
    for wait in (1.5, 0.0):
        for _ in range(round(0.2 / leaning.dt)):
            leaning.moved[RIGHT_HAND] += 0.05 * leaning.dt * ALONG
            leaning.run(leaning.dt)
        assert leaning.findings[-1].cause == "contact_slips"
        leaning.run(wait)
    assert len(leaning.findings) == 2
    assert leaning.phases[-1] == "unload"
    seconds_until(leaning, lambda: not leaning.retargeting.state.enabled[RIGHT_HAND], 15.0)
    leaning.run(1.0)
    assert leaning.phases[-1] == "hold"


def test_an_overloaded_hand_stops_what_moves(leaning: ContactWorld) -> None:
    leaning.extra[RIGHT_HAND, 2] = 210.0
    waited = seconds_until(leaning, lambda: bool(leaning.findings), 1.0)
    assert waited == pytest.approx(LIMITS.overload_time, abs=0.03)
    assert leaning.findings[0].cause == "hand_overload"
    leaning.run(0.02)
    assert leaning.told()[-1] == ("cup", "aborted")
    assert "limit 195 N" in leaning.events[-1].reason
    leaning.run(2.0)
    assert leaning.retargeting.state.enabled[RIGHT_HAND]
    assert len(leaning.findings) == 1


def test_a_hand_on_its_way_to_a_contact_that_touches_something_stays_there(
    model: ControlledModel, joints: Array
) -> None:
    world = ContactWorld(model, joints, {RIGHT_HAND: TABLE})
    world.switching.place(make_goal(BOOK))
    world.run(1.0)
    world.extra[RIGHT_HAND] = [-45.0, 0.0, 0.0]
    assert world.run(1.0, "aborted") == "aborted"
    assert "touched something" in world.events[-1].reason
    assert "cm before the point" in world.events[-1].reason
    assert world.findings[0].cause == "contact_unexpected"
    where = world.end_effectors.position(RIGHT_HAND)
    world.run(2.0)
    assert world.switching.phase == "hold"
    assert np.linalg.norm(world.end_effectors.position(RIGHT_HAND) - where) < 0.01


def test_an_arm_that_is_jerked_touches_nothing(model: ControlledModel, joints: Array) -> None:
    world = ContactWorld(model, joints, {RIGHT_HAND: TABLE})
    world.switching.place(make_goal(BOOK))
    world.run(1.0)
    for _ in range(3):
        world.extra[RIGHT_HAND] = [-45.0, 0.0, 0.0]
        world.run(0.1)
        world.extra[RIGHT_HAND] = 0.0
        world.run(0.1)
    assert world.findings == []
    world.extra[RIGHT_HAND] = [-110.0, 0.0, 0.0]
    world.run(0.03)
    assert [finding.cause for finding in world.findings] == ["contact_unexpected"]


def test_weight_that_shifts_slowly_in_the_air_is_no_touch(
    model: ControlledModel, joints: Array
) -> None:
    world = ContactWorld(model, joints, {LEFT_HAND: TABLE})
    world.switching.place(make_goal((0.45, 0.30, TABLE), "left_hand"))
    for _ in range(200):
        world.extra[LEFT_HAND, 0] += 0.06  # 6 N/s, as of a hand that turns
        world.run(world.dt)
    assert world.findings == []
    assert world.run(20.0, "loaded") == "loaded"


def test_sensors_that_read_nan_find_nothing(leaning: ContactWorld) -> None:
    leaning.extra[RIGHT_HAND] = np.nan
    leaning.moved[LEFT_FOOT] = np.nan
    leaning.run(1.0)
    assert leaning.findings == []


def test_a_finding_is_told_as_a_hazard(leaning: ContactWorld) -> None:
    leaning.gone.add(RIGHT_HAND)
    leaning.run(0.5)
    hazard = leaning.findings[0].hazard()
    assert (hazard.cause, hazard.subject, hazard.unit) == ("contact_lost", "right_hand", "N")
    assert hazard.value < hazard.limit
