"""One trial: push on a table, be knocked while pushing, then reach far with the other hand."""

from collections.abc import Mapping
from dataclasses import replace

import msgspec
import numpy as np
import numpy.typing as npt

from w2c.errors import ControlError
from w2c.library import library
from w2c.messages import EndEffector, PlaceGoal, Task
from w2c_evaluation.closed_loop import ClosedLoop

TABLE_TOP = (0.47, -0.25, 0.84)
"""Where the ball-ended hand pushes [m]"""
TABLE_HALF_SIZE = (0.12, 0.12, 0.02)
REACH = (1.1, 0.2, 0.9)
"""Where the other hand goes: beyond what two feet allow [m]"""
PUSH = 50.0
"""[N]"""
STAND_S = 2.5
GOAL_S = 30.0
"""For a goal to end."""
HOLD_S = 4.0
KNOCK = (40.0, 0.0, 0.0)
"""On the trunk [N]"""
KNOCK_S = 0.1
KNOCKED_S = 3.0
"""Of swinging after a knock."""
SETTLED_S = 2.0
"""The end of a hold, in which tracking is judged."""
SAMPLE_TICKS = 5
RIGHT_HAND = 3
UP = (0.0, 0.0, 1.0)
BACK = (-1.0, 0.0, 0.0)


METRICS = (
    "push_error",
    "push_ripple",
    "knock_ripple",
    "reach_error",
    "reach_peak",
    "hold_error",
    "foot_error",
)
"""Figures of an `Outcome` [N]"""


class Case(msgspec.Struct, frozen=True):
    """What one trial varies."""

    name: str
    """Of the gains"""
    gains: Mapping[str, float | str]
    """Of the controller's force feedback, where they are not its own"""
    stiffness: float = 1.0
    """True over modelled"""
    hand_mass: float = 0.0
    """Unmodelled, in the reaching hand [kg]"""


class Outcome(msgspec.Struct, frozen=True):
    """What a trial showed; errors are of the true normal force against the desired one [N]."""

    case: Case
    pushed: str
    """Event that ended the push"""
    reached: str
    """Event that ended the reach"""
    fell: bool
    push_error: float
    """Mean of the absolute error while the push is held"""
    push_ripple: float
    """Standard deviation then"""
    knock_ripple: float
    """Standard deviation of the normal force while the robot swings after a knock"""
    reach_error: float
    """Root mean square from the start of the reach to the end of its hold"""
    reach_peak: float
    hold_error: float
    """Mean of the absolute error at the end"""
    foot_error: float
    """Root mean square over both feet during the reach [N]"""
    reason: str = ""


def run_case(case: Case) -> Outcome:
    """Run one trial and judge it; one that could not be run has no figures, and says why."""
    try:
        return Trial(case).run()
    except ControlError as error:  # the other trials go on
        figures = dict.fromkeys(METRICS, float("nan"))
        return Outcome(case=case, pushed="", reached="", fell=False, reason=str(error), **figures)


class Trial:
    """The experiment, with its robot and controller."""

    def __init__(self, case: Case) -> None:
        self._case = case
        description = library("make_description")(lock_step=True)
        x, y, z = TABLE_TOP
        table = library("block")(centre=(x, y, z - TABLE_HALF_SIZE[2]), half_size=TABLE_HALF_SIZE)
        perturbation = library("perturbation")(
            stiffness=case.stiffness, hand_mass=(case.hand_mass, 0.0)
        )
        self._robot = library("study_robot")(perturbation, (table,), description=description)
        own = library("controller_parameters")()
        parameters = replace(own, force_control=replace(own.force_control, **case.gains))
        self._controller = library("controller")(description, parameters)
        self._loop = ClosedLoop(self._robot, self._controller)
        self._period_s = description.period_ns * 1e-9
        self._samples: list[npt.NDArray[np.float64]] = []

    def run(self) -> Outcome:
        """Run it to its end, or to its fall."""
        self._go(STAND_S)
        pushed = self._goal("push", "right_hand", "contact", TABLE_TOP, UP, force=PUSH)
        self._go(HOLD_S)
        push, self._samples = np.array(self._samples), []
        reached, knock = "", np.full((1, 6), np.nan)
        if pushed == "loaded":
            self._robot.push(np.array(KNOCK), KNOCK_S)
            self._go(KNOCKED_S)
            knock, self._samples = np.array(self._samples), []
            reached = self._goal("reach", "left_hand", "reach", REACH, BACK)
            self._go(HOLD_S)
        reach = np.array(self._samples) if self._samples else np.full((1, 6), np.nan)
        settled = round(SETTLED_S / (SAMPLE_TICKS * self._period_s))
        errors = [samples[:, 3:] - samples[:, :3] for samples in (push, reach)]
        hand = errors[1][:, 2]
        reasons = [event.reason for event in self._loop.events if event.state == "aborted"]
        return Outcome(
            case=self._case,
            pushed=pushed,
            reached=reached,
            fell=bool(self._robot.fell),
            push_error=float(np.abs(errors[0][-settled:, 2]).mean()),
            push_ripple=float(push[-settled:, 5].std()),
            knock_ripple=float(knock[:, 5].std()),
            reach_error=float(np.sqrt(np.mean(hand**2))),
            reach_peak=float(np.abs(hand).max()),
            hold_error=float(np.abs(hand[-settled:]).mean()),
            foot_error=float(np.sqrt(np.mean(errors[1][:, :2] ** 2))),
            reason=reasons[-1] if reasons else "",
        )

    def _goal(
        self,
        goal_id: str,
        hand: EndEffector,
        task: Task,
        point: tuple[float, float, float],
        normal: tuple[float, float, float],
        force: float = 0.0,
    ) -> str:
        """Give a goal and wait for its end. Returns the event, or why it was refused."""
        goal = PlaceGoal(
            goal_id=goal_id,
            end_effector=hand,
            task=task,
            point=np.array(point),
            normal=np.array(normal),
            force=force,
        )
        refusal = self._loop.ask(goal)
        return refusal or self._go(GOAL_S, "loaded", "reached", "unreachable", "aborted")

    def _go(self, seconds: float, *states: str) -> str:
        if self._robot.fell:
            return ""
        ticks = round(seconds / self._period_s)
        return self._loop.run(ticks, until=states, watch=self._sample)

    def _sample(self) -> bool:
        """Note vertical forces: desired of feet and pushing hand, then true."""
        robot = self._robot
        if robot.tick % SAMPLE_TICKS == 0:
            desired = self._controller.snapshot().desired_forces[[0, 1, RIGHT_HAND], 2]
            true = robot.truth().contact_forces[[0, 1, RIGHT_HAND], 2]
            self._samples.append(np.concatenate([desired, true]))
        return bool(robot.fell)
