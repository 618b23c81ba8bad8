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
    hand: int
    task: Task
    state: EventState
    reason: str = ""
    distance: float = -1.0
    """Between hand and target, by the model [m]; -1 where it has no meaning"""


def short_by(distance: float, cause: str = "balance or the arm's length") -> str:
    """Return the words for a target that was not reached."""
    return f"{cause} ends {100 * distance:.1f} cm short of the point"
