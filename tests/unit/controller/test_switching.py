"""The states of a goal, driven by forces that the test makes up."""

import numpy as np
import pytest

from fakes.contact_world import ContactWorld, make_goal
from w2c.messages import Array
from w2c_controller.kinematics.model import ControlledModel
from w2c_controller.parameters import LEFT_HAND, RIGHT_HAND, Motion, Parameters

DT = 0.01
IMPATIENT = Parameters(motion=Motion(load_timeout=5.0, unload_timeout=8.0))
TABLE = 0.84
NEAR = (0.45, -0.30, TABLE)
FAR_CUP = (1.6, 0.2, 0.9)
NEAR_CUP = (0.7, 0.3, 0.95)


@pytest.fixture
def in_air(model: ControlledModel, joints: Array) -> ContactWorld:
    """No surface but the floor."""
    return ContactWorld(model, joints, {}, IMPATIENT, DT)


@pytest.fixture
def at_table(model: ControlledModel, joints: Array) -> ContactWorld:
    """A table under the right hand."""
    return ContactWorld(model, joints, {RIGHT_HAND: TABLE}, IMPATIENT, DT)


def test_a_contact_is_touched_loaded_held_released_and_brought_back(at_table: ContactWorld) -> None:
    at_table.switching.place(make_goal(NEAR))
    assert at_table.run(30.0, "loaded") == "loaded"
    assert at_table.switching.phase == "contact"
    assert at_table.switching.busy_with() == ""
    assert at_table.retargeting.state.wrenches[3, 2] >= 9.9
    at_table.switching.release("r", 3)
    assert at_table.run(40.0, "released") == "released"
    assert at_table.phases == ["approach", "touch", "load", "contact", "unload", "retreat", "hold"]
    assert at_table.states() == ["moving", "touched", "loaded", "released"]
    assert at_table.events[-1].goal_id == "r"
    at_table.run(3.0)
    assert (
        np.linalg.norm(at_table.end_effectors.position(3) - at_table.end_effectors.rest[3]) < 0.01
    )


def test_a_contact_is_enabled_at_a_measured_force_only(at_table: ContactWorld) -> None:
    at_table.switching.place(make_goal(NEAR))
    at_table.run(30.0, "loaded")
    assert len(at_table.touched_at) == 1
    assert at_table.touched_at[0] > Motion().touch_force


def test_a_hand_comes_down_slowly_near_the_surface_and_slower_where_it_feels_it(
    at_table: ContactWorld,
) -> None:
    at_table.switching.place(make_goal(NEAR))
    speeds: dict[bool, float] = {}
    while not at_table.touched_at and len(at_table.phases) < 3:
        at_table.run(DT)
        if at_table.switching.phase == "touch":
            height = at_table.end_effectors.position(RIGHT_HAND)[2] - TABLE - 0.05
            near = height < 0.01
            before = speeds.get(near, 0.0)
            speeds[near] = max(before, at_table.end_effectors.speed(RIGHT_HAND))
            last = at_table.end_effectors.speed(RIGHT_HAND)
    top = Motion().touch_speed
    assert speeds[False] > 0.6 * top
    assert speeds[True] < 0.5 * top
    assert last < 0.25 * top


def test_nothing_to_lean_on_is_never_a_contact(in_air: ContactWorld) -> None:
    in_air.switching.place(make_goal(NEAR))
    assert in_air.run(30.0, "aborted") == "aborted"
    assert "no surface" in in_air.events[-1].reason
    assert in_air.touched_at == []
    in_air.run(12.0)
    assert in_air.switching.phase == "hold"


def test_an_unreachable_contact_is_given_up_with_the_gap(in_air: ContactWorld) -> None:
    in_air.switching.place(make_goal((1.5, -0.3, TABLE)))
    assert in_air.run(40.0, "aborted") == "aborted"
    assert in_air.states() == ["moving", "unreachable", "aborted"]
    assert in_air.events[1].distance > 0.2
    assert "cm short" in in_air.events[1].reason
    assert in_air.touched_at == []


def test_a_surface_that_does_not_carry_is_left_again(at_table: ContactWorld) -> None:
    at_table.hollow.add(RIGHT_HAND)
    at_table.switching.place(make_goal(NEAR))
    assert at_table.run(40.0, "aborted") == "aborted"
    assert "did not take its load" in at_table.events[-1].reason
    at_table.run(12.0)
    assert at_table.switching.phase == "hold"
    assert not at_table.retargeting.state.enabled[3]


def test_a_reach_arrives_and_holds(in_air: ContactWorld) -> None:
    in_air.switching.place(make_goal(NEAR_CUP, "left_hand", task="reach"))
    assert in_air.run(20.0, "reached") == "reached"
    assert 0 <= in_air.events[-1].distance < Motion().reached_distance
    in_air.run(2.0)
    assert in_air.switching.phase == "reach"
    assert in_air.states() == ["moving", "reached"]


def test_an_unreachable_point_is_approached_and_reported_once(in_air: ContactWorld) -> None:
    in_air.switching.place(make_goal(FAR_CUP, "left_hand", task="reach"))
    assert in_air.run(40.0, "unreachable") == "unreachable"
    gap = in_air.events[-1].distance
    assert gap == pytest.approx(in_air.switching.distance())
    assert 0.2 < gap < 0.6
    in_air.run(5.0)
    assert in_air.states() == ["moving", "unreachable"]
    assert in_air.switching.phase == "reach"
    assert in_air.retargeting.failures == 0


def test_a_reaching_hand_that_touches_stops(in_air: ContactWorld) -> None:
    in_air.switching.place(make_goal(NEAR_CUP, "left_hand", task="reach"))
    in_air.run(0.5)
    while in_air.switching.distance() > 0.05:
        in_air.run(DT)
    in_air.extra[LEFT_HAND] = np.array([-15.0, 0.0, 0.0])
    in_air.run(6.0)
    assert in_air.states()[-1] == "unreachable"
    assert "in the way" in in_air.events[-1].reason
    assert in_air.switching.distance() > 0.03


def test_a_single_hard_reading_on_the_way_is_the_arm_and_a_second_one_something_else(
    at_table: ContactWorld,
) -> None:
    """The command after a few lost ones leaps, and jerks the arm: that is over within 10 ms."""
    at_table.switching.place(make_goal(NEAR))
    at_table.run(0.5)
    hard = np.array([-130.0, 0.0, 0.0])
    at_table.extra[RIGHT_HAND] = hard
    at_table.run(DT)
    at_table.extra[RIGHT_HAND] = 0.6 * hard
    at_table.run(DT)
    at_table.extra[RIGHT_HAND] = 0.0
    at_table.run(0.5)
    assert at_table.switching.phase == "approach"
    at_table.extra[RIGHT_HAND] = hard
    at_table.run(2.0 * DT)
    assert at_table.states()[-1] == "aborted"
    assert [finding.cause for finding in at_table.findings] == ["contact_unexpected"]


def test_the_same_hand_may_be_sent_elsewhere_on_its_way(in_air: ContactWorld) -> None:
    in_air.switching.place(make_goal(FAR_CUP, "left_hand", task="reach", goal_id="first"))
    in_air.run(1.0)
    assert in_air.switching.busy_with() == "first"
    in_air.switching.place(make_goal(NEAR_CUP, "left_hand", task="reach", goal_id="second"))
    assert in_air.run(20.0, "reached") == "reached"
    assert in_air.events[-1].goal_id == "second"


def test_a_leaning_hand_unloads_before_it_goes_elsewhere(at_table: ContactWorld) -> None:
    at_table.switching.place(make_goal(NEAR, goal_id="first"))
    at_table.run(30.0, "loaded")
    at_table.switching.place(make_goal((0.5, -0.2, TABLE), goal_id="second"))
    assert at_table.run(60.0, "loaded") == "loaded"
    assert at_table.events[-1].goal_id == "second"
    assert at_table.phases[3:] == [
        "contact",
        "unload",
        "retreat",
        "approach",
        "touch",
        "load",
        "contact",
    ]


def test_a_support_stays_while_the_other_hand_reaches(at_table: ContactWorld) -> None:
    at_table.switching.place(make_goal(NEAR))
    at_table.run(30.0, "loaded")
    at_table.switching.place(make_goal(NEAR_CUP, "left_hand", task="reach", goal_id="cup"))
    assert at_table.run(20.0, "reached") == "reached"
    assert at_table.retargeting.state.enabled == (True, True, False, True)
    assert at_table.retargeting.loaded(3)


def test_weight_that_cannot_be_taken_off_is_reported_and_kept(
    at_table: ContactWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    at_table.switching.place(make_goal(NEAR))
    at_table.run(30.0, "loaded")
    at_table.switching.release("r", 3)
    monkeypatch.setattr(at_table.retargeting, "release", lambda _: None)
    at_table.retargeting.keep(3)
    assert at_table.run(40.0, "aborted") == "aborted"
    assert "cannot be taken off" in at_table.events[-1].reason
    assert at_table.retargeting.state.enabled[3]
    assert at_table.switching.phase == "hold"


def test_abort_leaves_hands_where_they_are(in_air: ContactWorld) -> None:
    in_air.switching.place(make_goal(FAR_CUP, "left_hand", task="reach"))
    in_air.run(3.0)
    where = in_air.end_effectors.position(2)
    in_air.switching.abort("stopped")
    in_air.run(3.0)
    assert in_air.events[-1].state == "aborted"
    assert in_air.switching.phase == "hold"
    assert np.linalg.norm(in_air.end_effectors.position(2) - where) < 0.03


def test_a_goal_that_is_replaced_is_told_to_have_ended(in_air: ContactWorld) -> None:
    in_air.switching.place(make_goal(FAR_CUP, "left_hand", task="reach", goal_id="first"))
    in_air.run(1.0)
    in_air.switching.place(make_goal(NEAR_CUP, "left_hand", task="reach", goal_id="second"))
    in_air.run(1.0)
    in_air.switching.release("third", 2)
    assert in_air.run(20.0, "released") == "released"
    told = [(event.goal_id, event.state) for event in in_air.events]
    assert told == [
        ("first", "moving"),
        ("first", "aborted"),
        ("second", "moving"),
        ("second", "aborted"),
        ("third", "released"),
    ]
    assert "second" in in_air.events[1].reason
