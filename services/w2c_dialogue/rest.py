"""What became of the last motion: the robot rests where it ended, until something ends that."""

from typing import Literal

from w2c.messages import GoalEvent

Rest = Literal["idle", "in_contact", "reached"]


class LastMotion:
    """Where the end effector of the last goal is."""

    def __init__(self) -> None:
        self.rest: Rest = "idle"
        self._goal_id = ""

    def end(self, goal_id: str, rest: Rest) -> None:
        """Take in the end of a goal."""
        self.rest, self._goal_id = rest, goal_id

    def follow(self, event: GoalEvent) -> None:
        """Take in what happens later: a release by its own id, or a contact that is lost."""
        lost = event.goal_id == self._goal_id and event.state == "aborted"
        if lost or event.state == "released":
            self.rest = "idle"
