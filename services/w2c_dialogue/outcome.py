"""What a turn came to, and the goal that a confirmed target becomes."""

from dataclasses import dataclass, replace

from w2c.errors import RefusedError
from w2c.messages import ConversationState, EndEffector, Evidence, PlaceGoal, Target, Task, Turn
from w2c_dialogue.conversation import Goal


@dataclass(frozen=True)
class Outcome:
    """What a turn came to."""

    module: str
    reply: str
    target: Target | None = None
    goal: Goal | None = None
    ok: bool = True
    retryable: bool = False
    """Whether the same may succeed a little later"""
    options: tuple[str, ...] = ()
    """What may be answered to a question"""

    def with_reply(self, reply: str) -> "Outcome":
        """Return the same, told in other words."""
        return replace(self, reply=reply)

    def as_turn(
        self,
        stamp_ns: int,
        text: str,
        seconds: float,
        steps: dict[str, float],
        *,
        state: ConversationState,
        evidence: Evidence | None = None,
    ) -> Turn:
        """Return the message about it.

        Args:
            stamp_ns: Now.
            text: What was said.
            seconds: In all [s].
            steps: In each step [s].
            state: Of the conversation, after it.
            evidence: What it was made from.
        """
        return Turn(
            stamp_ns=stamp_ns,
            text=text,
            module=self.module,
            reply=self.reply,
            ok=self.ok,
            retryable=self.retryable,
            options=list(self.options),
            target=self.target,
            goal_id=self.goal.goal_id if self.goal else "",
            end_effector=self.goal.effector if self.goal else "",
            task=self.goal.task if self.goal else "",
            seconds=seconds,
            steps=steps,
            state=state,
            evidence=evidence,
        )


def goal_of(goal_id: str, target: Target, limb: EndEffector, task: Task) -> PlaceGoal:
    """Return the goal of a target. Raises RefusedError for one that cannot be reached."""
    if target.point is None or target.normal is None:
        raise RefusedError("There is no depth at the target. Move it, then confirm again.")
    try:
        return PlaceGoal(
            goal_id=goal_id, end_effector=limb, task=task, point=target.point, normal=target.normal
        )
    except ValueError as error:
        raise RefusedError(f"The robot cannot go to that point ({error}). Name another.") from error
