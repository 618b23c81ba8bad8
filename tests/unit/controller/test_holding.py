"""When a guard finds something the controller holds, says why, and goes on by rule."""

from collections.abc import Callable

import msgspec
import numpy as np
import pytest

from fakes.ideal_robot import IdealRobot
from w2c.errors import GoalRefusedError, SolverError
from w2c.messages import Array, PlaceGoal, RobotDescription, RobotState
from w2c.messages.control import SafetyCause
from w2c_controller.controller import Controller
from w2c_controller.safety.guards import SENSE_EVERY
from w2c_controller.safety.hazards import RULES, Hazard
from w2c_controller.safety.uptake import FARTHEST_AHEAD

STANDS = 220
"""Ticks until the controller's own command is in force."""


@pytest.fixture
def description(description: RobotDescription) -> RobotDescription:
    """A robot with ticks of 10 ms: five times faster tests."""
    return msgspec.structs.replace(description, period_ns=10_000_000)


class Cell:
    """A robot whose states may be spoilt on their way, and its controller, reaching."""

    def __init__(self, description: RobotDescription) -> None:
        self.robot = IdealRobot(description)
        self.controller = Controller(description)
        self.n = len(description.joints)
        self.run(STANDS)
        self.place("g")
        self.run(100)
        assert self.controller.phase == "approach"
        self.controller.take_events()

    def place(self, goal_id: str) -> None:
        self.controller.requests.place(
            PlaceGoal(
                goal_id=goal_id,
                end_effector="left_hand",
                task="reach",
                point=np.array([0.7, 0.3, 0.95]),
                normal=np.array([0.0, 0.0, 1.0]),
            )
        )

    def run(self, ticks: int, spoil: Callable[[RobotState], RobotState] = lambda s: s) -> Array:
        """Return the commands (ticks, n)."""
        commands = []
        for _ in range(ticks):
            answer = self.controller.tick(spoil(self.robot.state()))
            if self.robot.mode != "stopped":
                self.robot.command, self.robot.mode = answer.position, "tracking"
            self.robot.tick += 1
            commands.append(answer.position)
        return np.array(commands)

    def phase(self) -> str:
        return self.controller.phase

    def reports(self) -> list[tuple[SafetyCause, bool]]:
        return [(r.hazard.cause, r.begins) for r in self.controller.take_safety_reports()]

    def ends(self) -> list[str]:
        return [event.state for event in self.controller.take_events()]


@pytest.fixture
def cell(description: RobotDescription) -> Cell:
    return Cell(description)


def spoilt(field: str, joint: int, value: float) -> Callable[[RobotState], RobotState]:
    """Return what puts a wrong reading into states."""

    def spoil(state: RobotState) -> RobotState:
        readings = getattr(state, field).copy()
        readings[joint] = value
        return msgspec.structs.replace(state, **{field: readings})

    return spoil


def test_a_reading_that_is_no_number_pauses_and_the_motion_goes_on(cell: Cell) -> None:
    held = cell.run(12, spoilt("torque", 3, np.nan))[4:]
    np.testing.assert_array_equal(held, np.broadcast_to(held[0], held.shape))
    assert cell.phase() == "held"
    with pytest.raises(GoalRefusedError, match="reads no number"):
        cell.place("other")
    moved = cell.run(100)
    assert np.abs(moved[-1] - held[0]).max() > 0.01
    assert np.abs(np.diff(moved, axis=0)).max() < 0.01
    assert cell.reports() == [("sensor_not_finite", True), ("sensor_not_finite", False)]
    assert "aborted" not in cell.ends()


def test_the_motion_does_not_run_ahead_of_a_robot_that_takes_no_commands(cell: Cell) -> None:
    """Late commands are refused: what was refused must not come as one leap afterwards."""
    robot, taken = cell.robot, cell.robot.tick - 1
    for ahead in range(15):
        answer = cell.controller.tick(msgspec.structs.replace(robot.state(), command_tick=taken))
        step = float(np.abs(answer.position - robot.command).max())
        robot.tick += 1
        if ahead == FARTHEST_AHEAD - 1:
            farthest = step
    assert farthest > 0.0
    assert step == farthest
    assert answer.tick == robot.tick - 1
    robot.command = answer.position
    moved = cell.run(100)
    assert np.abs(moved[-1] - answer.position).max() > 0.01
    assert np.abs(np.diff(moved, axis=0)).max() < 0.01
    assert cell.reports() == []
    assert cell.phase() == "approach"


@pytest.mark.parametrize("first", range(SENSE_EVERY))
def test_with_ticks_that_did_not_come_it_measures_as_often(cell: Cell, first: int) -> None:
    """A slow machine answers one tick in seven, never mind which: each of them is looked at."""
    cell.robot.tick += first
    spoil = spoilt("torque", 3, np.nan)
    for _ in range(2):
        cell.controller.tick(spoil(cell.robot.state()))
        cell.robot.tick += 7
    assert cell.reports().count(("sensor_not_finite", True)) == 2


def test_a_long_pause_ends_the_goal(cell: Cell) -> None:
    cell.run(120, spoilt("torque", 3, np.nan))
    assert cell.ends() == ["aborted"]
    cell.run(20)
    assert cell.phase() != "held"


@pytest.mark.parametrize(
    ("cause", "spoil"),
    [
        ("position_limit", spoilt("position", 20, 9.0)),
        ("velocity_limit", spoilt("velocity", 20, 50.0)),
        ("torque_limit", spoilt("torque", 20, -900.0)),
        ("not_following", spoilt("position", 3, 1.3)),
    ],
)
def test_a_limit_that_is_exceeded_holds_until_resume(
    cell: Cell, cause: SafetyCause, spoil: Callable[[RobotState], RobotState]
) -> None:
    cell.run(16, spoil)
    assert cell.ends() == ["aborted"]
    assert (cause, True) in cell.reports()
    held = cell.run(50)
    np.testing.assert_array_equal(held, np.broadcast_to(held[0], held.shape))
    assert "w2c resume" in cell.controller.snapshot().message
    cell.controller.resume()
    after = cell.run(240)
    assert np.abs(np.diff(np.vstack([held[-1:], after]), axis=0)).max() < 0.01
    assert (cause, False) in cell.reports()
    assert cell.phase() == "hold"
    cell.place("again")


def test_frozen_readings_hold_and_good_ones_end_it(cell: Cell) -> None:
    frozen = cell.robot.state()

    def freeze(state: RobotState) -> RobotState:
        return msgspec.structs.replace(state, position=frozen.position, torque=frozen.torque)

    cell.run(40, freeze)
    assert ("sensor_frozen", True) in cell.reports()
    assert cell.ends() == ["aborted"]
    cell.run(round(RULES["sensor_frozen"].good_time / 0.01) + 10)
    assert ("sensor_frozen", False) in cell.reports()
    assert cell.phase() != "held"


def test_a_command_that_jumps_is_not_sent(cell: Cell) -> None:
    before = cell.run(1)[0]
    cell.controller.retargeting.state.q[10] += 0.5
    after = cell.run(20)
    np.testing.assert_array_equal(after, np.broadcast_to(before, after.shape))
    assert ("command_jump", True) in cell.reports()
    cell.controller.resume()
    assert np.abs(np.diff(cell.run(240), axis=0)).max() < 0.01


def test_a_command_that_is_not_finite_is_not_sent(cell: Cell) -> None:
    before = cell.run(1)[0]
    cell.controller.force_control.flexible.offset[4] = np.nan
    after = cell.run(5)
    np.testing.assert_array_equal(after, np.broadcast_to(before, after.shape))
    assert ("command_not_finite", True) in cell.reports()


def test_programs_without_solution_hold_the_robot(
    cell: Cell, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(_: object) -> Array:
        raise SolverError("infeasible")

    monkeypatch.setattr(cell.controller.solvers[0], "solve", fail)
    limit = cell.controller.parameters.guards.failed_programs
    moved = cell.run(limit + 20)
    assert np.abs(np.diff(moved[2:], axis=0)).max() < 1e-3
    assert ("qp_failed", True) in cell.reports()
    assert cell.ends() == ["aborted"]
    monkeypatch.undo()
    cell.controller.resume()
    cell.run(20)
    assert cell.phase() != "held"


def test_a_hand_that_bears_too_much_holds(cell: Cell) -> None:
    cell.robot.lean(np.array([0.0, 0.0, 400.0]))
    cell.run(60)
    assert ("hand_overload", True) in cell.reports()
    assert cell.phase() == "held"


def test_a_driver_that_refuses_is_followed_until_it_listens(cell: Cell) -> None:
    command = cell.robot.command.copy()

    def refuse(state: RobotState) -> RobotState:
        return msgspec.structs.replace(state, mode="holding", command=command)

    cell.run(60, refuse)
    assert ("command_not_taken", True) in cell.reports()
    np.testing.assert_array_equal(cell.run(1, refuse)[0], command)
    cell.run(20)
    assert cell.phase() != "held"


def test_what_is_found_outside_pauses_until_the_next_good_state(cell: Cell) -> None:
    cell.controller.found(Hazard("state_stale", "no state for 120 ms"))
    assert cell.phase() == "held"
    cell.run(1)
    assert cell.phase() == "approach"
    assert cell.reports() == [("state_stale", True), ("state_stale", False)]


def test_states_that_stayed_away_for_long_end_the_goal(cell: Cell) -> None:
    cell.controller.found(Hazard("state_stale", "no state for 2000 ms"))
    cell.robot.tick += 200
    cell.run(1)
    assert cell.ends() == ["aborted"]


def test_a_stop_that_did_not_reach_the_driver_ends_with_resume(cell: Cell) -> None:
    cell.controller.freeze("red button")
    held = cell.run(50)
    np.testing.assert_array_equal(held, np.broadcast_to(held[0], held.shape))
    assert cell.phase() == "stopped"
    cell.controller.resume()
    cell.run(240)
    assert cell.phase() == "hold"
    cell.place("again")


def test_resume_at_the_driver_ends_all_that_waits_for_an_operator(cell: Cell) -> None:
    cell.run(16, spoilt("velocity", 20, 50.0))
    cell.robot.mode = "stopped"
    cell.run(5)
    cell.robot.mode = "holding"
    cell.run(5)
    assert cell.phase() != "held"


def test_resume_does_not_end_a_stop_of_the_driver(cell: Cell) -> None:
    cell.robot.mode = "stopped"
    cell.run(5)
    cell.controller.resume()
    cell.run(5)
    assert cell.phase() == "stopped"


def test_a_spoilt_state_at_the_start_is_waited_out(description: RobotDescription) -> None:
    robot, controller = IdealRobot(description), Controller(description)
    spoil = spoilt("position", 0, np.nan)
    for _ in range(3):
        answer = controller.tick(spoil(robot.state()))
        np.testing.assert_array_equal(answer.position, robot.command)
        robot.tick += 1
    assert not controller.takeover.done
    robot.step(controller, 20)
    assert controller.takeover.done
