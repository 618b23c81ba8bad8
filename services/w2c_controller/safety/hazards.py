"""What must not be, what the controller does about it, and when it goes on.

The answer is never to switch motors off: a robot that holds its last command stands. Two answers:

    pauses   the command waits, goals stay; the next good state goes on where it stopped. A pause
             of more than a second becomes a hold
    holds    goals are aborted, the command in force is kept

A hold ends by itself once its cause is gone for a while, or an operator ends it: see `RULES`.
"""

from dataclasses import dataclass, replace
from typing import Literal

from w2c.messages.control import SafetyCause

Answer = Literal["pauses", "holds"]
Ending = Literal["by itself", "after resume"]

LONGEST_PAUSE = 1.0
"""A pause that lasts longer is a hold [s]."""


@dataclass(frozen=True)
class Rule:
    """How one cause is answered."""

    answer: Answer
    resumes: Ending
    good_time: float
    """How long the cause must be gone before the robot goes on by itself [s]"""
    advice: str
    """What a person may do"""


_RESUME = "look at the robot, then: w2c resume"

RULES: dict[SafetyCause, Rule] = {
    "sensor_not_finite": Rule("pauses", "by itself", 0.05, "check the sensor and its cable"),
    "sensor_frozen": Rule(
        "holds", "by itself", 0.5, "check the driver: its readings do not change"
    ),
    "state_stale": Rule("pauses", "by itself", 0.0, "check the robot driver and its link"),
    "state_out_of_order": Rule("pauses", "by itself", 0.0, "check the robot driver"),
    "position_limit": Rule("holds", "after resume", 0.0, f"free the joint; {_RESUME}"),
    "velocity_limit": Rule("holds", "after resume", 0.0, _RESUME),
    "torque_limit": Rule("holds", "after resume", 0.0, f"take the load off; {_RESUME}"),
    "not_following": Rule("holds", "after resume", 0.0, f"check the joint's motor; {_RESUME}"),
    "command_jump": Rule("holds", "after resume", 0.0, _RESUME),
    "command_not_finite": Rule("holds", "after resume", 0.0, _RESUME),
    "command_not_taken": Rule("pauses", "by itself", 0.0, "see why the driver refuses commands"),
    "qp_failed": Rule("holds", "after resume", 0.0, f"release what the hands do; {_RESUME}"),
    "hand_overload": Rule("holds", "after resume", 0.0, f"take the load off; {_RESUME}"),
    "contact_lost": Rule("holds", "after resume", 0.0, f"see what gave way; {_RESUME}"),
    "contact_slips": Rule("holds", "after resume", 0.0, f"see what gave way; {_RESUME}"),
    "contact_unexpected": Rule("holds", "after resume", 0.0, f"clear the way; {_RESUME}"),
    "stopped": Rule("holds", "after resume", 0.0, "w2c resume"),
    "no_snapshot": Rule(
        "holds", "after resume", 0.0, "to go on with the hands where they lean: w2c resume"
    ),
}


@dataclass(frozen=True)
class Hazard:
    """Something that a guard found."""

    cause: SafetyCause
    text: str
    """For the operator, with value, limit and unit"""
    subject: str = ""
    """Which joint, sensor or end effector"""
    value: float = 0.0
    limit: float = 0.0
    unit: str = ""


@dataclass(frozen=True)
class SafetyReport:
    """A hazard began or ended, with the answer to it."""

    hazard: Hazard
    begins: bool
    tick: int
    answered: bool = False
    """Whether goals ended already, and the loop goes on balancing"""

    @property
    def rule(self) -> Rule:
        """How it is answered."""
        rule = RULES[self.hazard.cause]
        return replace(rule, resumes="by itself") if self.answered else rule


@dataclass
class _Active:
    """A hazard that was found and did not end yet."""

    hazard: Hazard
    since: int
    last: int


class Holds:
    """Which hazards keep the robot from moving now. Counts ticks, knows no clock."""

    def __init__(self, dt: float) -> None:
        self._dt = dt
        self._active: dict[SafetyCause, _Active] = {}
        self._reports: list[SafetyReport] = []

    def __bool__(self) -> bool:
        """Whether anything does."""
        return bool(self._active)

    def found(self, hazard: Hazard, tick: int) -> None:
        """Note that a guard finds this now; call it at each tick while it does."""
        active = self._active.get(hazard.cause)
        if active is not None:
            active.last = tick
            return
        self._active[hazard.cause] = _Active(hazard, tick, tick)
        self._reports.append(SafetyReport(hazard, begins=True, tick=tick))

    def tell(self, hazard: Hazard, tick: int) -> None:
        """Report a hazard that was answered where it was found, and keeps nothing from moving."""
        for begins in (True, False):
            self._reports.append(SafetyReport(hazard, begins=begins, tick=tick, answered=True))

    def advance(self, tick: int) -> None:
        """End what is over by itself."""
        for cause, active in tuple(self._active.items()):
            rule = RULES[cause]
            gone = (tick - active.last) * self._dt
            if rule.resumes == "by itself" and gone > rule.good_time:
                self._end(cause, tick)

    def end(self, cause: SafetyCause, tick: int) -> None:
        """End one hazard: whoever found it knows that it is over."""
        if cause in self._active:
            self._end(cause, tick)

    def resume(self, tick: int) -> None:
        """End all that waits for an operator. What is still there is found again at once."""
        for cause in self.waiting:
            self._end(cause, tick)

    @property
    def waiting(self) -> tuple[SafetyCause, ...]:
        """Which of them wait for an operator."""
        if not self._active:
            return ()
        return tuple(cause for cause in self._active if RULES[cause].resumes == "after resume")

    def inherit(self, previous: "Holds", tick: int) -> None:
        """Go on with what made a controller before this one wait for an operator."""
        for cause in previous.waiting:
            self.found(previous._active[cause].hazard, tick)

    def active(self, cause: SafetyCause) -> bool:
        """Return whether this is one of the hazards now."""
        return cause in self._active

    def must_hold(self, tick: int) -> bool:
        """Return whether goals must be aborted, rather than wait."""
        longest = LONGEST_PAUSE / self._dt
        return any(
            RULES[cause].answer == "holds" or tick - active.since > longest
            for cause, active in self._active.items()
        )

    def text(self) -> str:
        """Return for the operator what happened and what to do; "" = nothing."""
        if not self._active:
            return ""
        return "; ".join(
            f"{active.hazard.text}: {RULES[cause].advice}" for cause, active in self._active.items()
        )

    def take_reports(self) -> list[SafetyReport]:
        """Return what began and ended since the last call."""
        if not self._reports:
            return []
        reports, self._reports = self._reports, []
        return reports

    def _end(self, cause: SafetyCause, tick: int) -> None:
        active = self._active.pop(cause)
        self._reports.append(SafetyReport(active.hazard, begins=False, tick=tick))
