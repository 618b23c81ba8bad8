"""What a hazard does to the robot, and when it goes on."""

import typing

from w2c.messages.control import SafetyCause
from w2c_controller.safety.hazards import LONGEST_PAUSE, RULES, Hazard, Holds

DT = 0.002


def test_every_cause_has_a_rule_with_advice() -> None:
    assert set(RULES) == set(typing.get_args(SafetyCause))
    assert all(rule.advice for rule in RULES.values())


def test_a_hazard_is_told_once_when_it_begins_and_once_when_it_ends() -> None:
    holds = Holds(DT)
    for tick in range(10):
        holds.advance(tick)
        holds.found(Hazard("sensor_not_finite", "no number"), tick)
    assert holds
    assert [report.begins for report in holds.take_reports()] == [True]
    for tick in range(10, 60):
        holds.advance(tick)
    assert not holds
    (report,) = holds.take_reports()
    assert not report.begins
    assert report.tick == 9 + round(RULES["sensor_not_finite"].good_time / DT) + 1
    assert holds.take_reports() == []


def test_what_waits_for_an_operator_does_not_end_by_itself() -> None:
    holds = Holds(DT)
    holds.found(Hazard("torque_limit", "too much"), 0)
    holds.advance(1_000_000)
    assert holds
    assert "w2c resume" in holds.text()
    holds.resume(1_000_001)
    assert not holds


def test_resume_does_not_end_what_is_still_wrong_with_the_sensors() -> None:
    holds = Holds(DT)
    holds.found(Hazard("sensor_frozen", "still"), 0)
    holds.resume(1)
    assert holds.active("sensor_frozen")


def test_a_long_pause_becomes_a_hold() -> None:
    holds = Holds(DT)
    holds.found(Hazard("sensor_not_finite", "no number"), 0)
    assert not holds.must_hold(10)
    assert holds.must_hold(round(LONGEST_PAUSE / DT) + 1)


def test_a_fault_of_the_robot_is_a_hold_at_once() -> None:
    holds = Holds(DT)
    holds.found(Hazard("hand_overload", "too much"), 0)
    assert holds.must_hold(0)
