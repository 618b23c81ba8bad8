"""Which goal is under way, in which phase, and what was told of it."""

from w2c_controller.goals.goals import Goal
from w2c_controller.parameters import HANDS
from w2c_controller.switching.blocking import spoken
from w2c_controller.switching.events import Event, EventLog, EventState, GoalPhase

BUSY = ("approach", "touch", "load", "unload", "retreat")
"""Phases in which no other end effector may begin a goal."""


class Bookkeeping:
    """The part of the state machine that does not move anything."""

    def __init__(self) -> None:
        self.phase: GoalPhase = "hold"
        self.goal: Goal | None = None
        self.releasing_id = ""
        """Id of the release that is under way."""
        self._effector = HANDS[0]
        self._log = EventLog()

    def busy_with(self) -> str:
        """Return the id of the goal that must end before another one may begin; "" = none."""
        if self.phase not in BUSY:
            return ""
        if self.goal is not None:
            return self.goal.goal_id
        return self.releasing_id or f"the retreat of the {spoken(self._effector)}"

    def busy_effector(self) -> int:
        """Return the end effector of the goal under way."""
        return self._effector

    def _unfinished(self) -> bool:
        """Return whether a goal is under way whose end was not told yet."""
        return self.phase in BUSY or (self.phase == "reach" and not self._log.told_end)

    def _supersede(self, goal_id: str) -> None:
        """Tell the end of a goal that another one replaces."""
        if self._unfinished() and (self.goal is not None or self.releasing_id):
            self._emit("aborted", f"replaced by goal '{goal_id}'")

    def _forget_goal(self) -> None:
        self.goal, self.releasing_id = None, ""

    def _emit_new(self, state: EventState, reason: str = "", distance: float = -1.0) -> None:
        if not self._log.told(state):
            self._emit(state, reason, distance)

    def _emit(self, state: EventState, reason: str = "", distance: float = -1.0) -> None:
        goal_id = self.goal.goal_id if self.goal is not None else self.releasing_id
        task = self.goal.task if self.goal is not None else "contact"
        self._log.add(Event(goal_id, self._effector, task, state, reason, distance))

    def _require_goal(self) -> Goal:
        if self.goal is None:
            raise RuntimeError(f"phase {self.phase} of the {spoken(self._effector)} has no goal")
        return self.goal
