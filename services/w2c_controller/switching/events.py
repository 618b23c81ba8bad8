"""What is told of a goal."""

from dataclasses import dataclass
from typing import Literal

from w2c.messages import Task

GoalPhase = Literal["hold", "approach", "touch", "load", "contact", "reach", "unload", "retreat"]
EventState = Literal[
    "accepted", "moving", "touched", "loaded", "reached", "unreachable", "released", "aborted"
]


@dataclass(frozen=True)
class Event:
    """A goal changed its state."""

    goal_id: str
    effector: int
    task: Task
    state: EventState
    reason: str = ""
    distance: float = -1.0
    """Between hand and target, by the model [m]; -1 where it has no meaning"""


def short_by(distance: float, cause: str = "balance or the arm's length") -> str:
    """Return the words for a target that was not reached."""
    return f"{cause} ends {100 * distance:.1f} cm short of the point"


ENDS: tuple[EventState, ...] = ("loaded", "reached", "unreachable", "released", "aborted")


class EventLog:
    """What happened since it was last asked, and what was told of the present goal."""

    def __init__(self) -> None:
        self._events: list[Event] = []
        self._told: set[EventState] = set()

    def begin(self) -> None:
        """Start with a new goal."""
        self._told.clear()

    def add(self, event: Event) -> None:
        """Note an event."""
        self._told.add(event.state)
        self._events.append(event)

    def told(self, state: EventState) -> bool:
        """Return whether this was told of the present goal."""
        return state in self._told

    @property
    def told_end(self) -> bool:
        """Whether the present goal was told to have ended, well or badly."""
        return any(state in self._told for state in ENDS)

    def take(self) -> list[Event]:
        """Return the events since the last call."""
        events, self._events = self._events, []
        return events
