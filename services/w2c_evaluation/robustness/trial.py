"""One trial: stand, reach as far as the true mass allows, hold, return, stand."""

import time
from dataclasses import replace
from typing import Any

import numpy as np

from w2c.errors import ControlError
from w2c.library import library
from w2c.messages import PlaceGoal, ReleaseGoal
from w2c_evaluation.closed_loop import ClosedLoop
from w2c_evaluation.demo.operator import REACH_STANDOFF_M
from w2c_evaluation.robustness import survival
from w2c_evaluation.robustness.grid import Cause, Cell, Mode, Target, TrialResult
from w2c_evaluation.robustness.survival import Trace
from w2c_evaluation.robustness.targets import HAND, HAND_INDEX

STAND_S = 3.0
"""Before the reach: the blend of the controller's start, and a second."""
REACH_S = 90.0
"""In which the target must be reached."""
HOLD_S = 5.0
RETURN_S = 90.0
REST_S = 5.0

LIMITS = {"cop_x": 0.07, "cop_y": 0.045, "torque_fraction": 0.85}
"""Of the controller in all modes. With its everyday margins (4 x 3 cm, 65 %) it stays so far from
the physical limits that it survives without any force control."""
TORQUE_RATIOS = {"torque_ratio": 0.95, "torque_ratio_release": 0.90}
"""Of the adaptive torque limits: above what the posture is allowed to ask for."""
FORCE_CONTROL: dict[Mode, str] = {
    "no_force_control": "off",
    "no_torque_limit": "no_torque_limit",
    "full": "full",
}
LEAD_TIME = 0.1
"""The commanded point may run this far ahead of the hand [s], and the distance in which the hand
brakes; the filter's own lag is 0.08 s."""
ACCELERATION = 0.8
"""Of the hand [m/s^2]. At SEIKO's 2 m/s^2, 12 kg at 1 m height alone move the centre of pressure
by 2.5 cm."""
HASTE = 1.875
"""Peak over mean of the minimum-jerk law: the path alone would take as long as at constant speed,
and the filter cuts its peak off at the commanded speed."""
NEVER = 1e6
"""A force that is not reached: the mass in the hand is no obstacle on its way [N]."""


def trial_parameters(mode: Mode, speed: float) -> Any:
    """Return the controller's parameters of a trial: its own, at this speed and in this mode."""
    own = library("controller_parameters")()
    lead = speed**2 / (2.0 * ACCELERATION) + LEAD_TIME * speed
    filters = own.filters
    return replace(
        own,
        limits=replace(own.limits, **LIMITS),
        filters=replace(
            filters,
            speed=speed,
            acceleration=ACCELERATION,
            lead_position=max(filters.lead_position, lead),
        ),
        motion=replace(
            own.motion,
            speed=HASTE * speed,
            reach_speed=HASTE * speed,
            bump_force=NEVER,
            air_bump_force=NEVER,
        ),
        force_control=replace(own.force_control, mode=FORCE_CONTROL[mode], **TORQUE_RATIOS),
    )


def run_trial(cell: Cell, target: Target, stiffness: float = 1.0) -> TrialResult:
    """Run a trial and judge it.

    Args:
        cell: Mode, speed and mass.
        target: Of the same trial and mass.
        stiffness: Of the simulated joints over those that the controller knows.
    """
    return Trial(cell, target, stiffness).run()


class Trial:
    """The experiment, with its robot and controller."""

    def __init__(self, cell: Cell, target: Target, stiffness: float) -> None:
        self._cell = cell
        self._target = target
        description = library("make_description")(lock_step=True)
        perturbation = library("perturbation")(hand_mass=(0.0, cell.mass), stiffness=stiffness)
        self._period_s = description.period_ns * 1e-9
        self._robot = library("study_robot")(perturbation, description=description)
        controller = library("controller")(description, trial_parameters(cell.mode, cell.speed))
        self._loop = ClosedLoop(self._robot, controller)
        self._every = round(survival.SAMPLE_S / self._period_s)
        self.trace = Trace(target)

    def run(self) -> TrialResult:
        """Run it to its end, or to its fall."""
        begun = time.process_time()
        deadline = STAND_S + REACH_S
        try:
            refusal = self._perform()
        except ControlError as error:  # a trial that breaks is not survived; the study goes on
            refusal = str(error)
        cause: Cause = survival.judge(self.trace, deadline)
        if refusal and not self.trace.fell:
            cause = "refused"
        events = [f"{event.state} {event.reason}".strip() for event in self._loop.events]
        return TrialResult(
            cell=self._cell,
            survived=cause == "",
            cause=cause,
            reached=survival.reached(self.trace, deadline),
            achieved_speed=survival.achieved_speed(self.trace),
            top_speed=survival.top_speed(self.trace),
            robot_seconds=self._robot.tick * self._period_s,
            cpu_seconds=time.process_time() - begun,
            detail=refusal or "; ".join(events[-3:]),
        )

    def _perform(self) -> str:
        """Play the trial. Returns why the controller refused a part of it, or ""."""
        self._wait(STAND_S)
        direction = np.array(self._target.direction)
        # The hand stops this far before the goal's point; its frame shall be at the target.
        off = self._loop.controller.description.hand_radius[HAND_INDEX - 2] + REACH_STANDOFF_M
        goal = PlaceGoal(
            goal_id="far",
            end_effector=HAND,
            task="reach",
            point=np.array(self._target.point) + off * direction,
            normal=-direction,
        )
        refusal = self._loop.ask(goal)
        if refusal:
            return refusal
        self._wait(REACH_S, "reached", "unreachable", "aborted")
        self._wait(HOLD_S)
        if self.trace.fell:
            return ""
        refusal = self._loop.ask(ReleaseGoal(goal_id="back", end_effector=HAND))
        if refusal:
            return refusal
        self._wait(RETURN_S, "released", "aborted")
        self._wait(REST_S)
        return ""

    def _wait(self, seconds: float, *states: str) -> None:
        """Go on for some time, or until the goal has one of these states, or the robot fell."""
        if not self.trace.fell:
            self._loop.run(round(seconds / self._period_s), until=states, watch=self._sample)

    def _sample(self) -> bool:
        robot = self._robot
        if robot.tick % self._every == 0 or robot.fell:
            self.trace.add(robot.truth(), robot.tick * self._period_s, HAND_INDEX)
        return bool(robot.fell)
