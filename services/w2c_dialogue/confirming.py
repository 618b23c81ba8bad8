"""From a confirmed target to a robot that moves: everything that is asked before it does.

A robot that moves already turns to the new target: the controller takes a goal of the limb that is
on its way, and goes on without a jump of velocity. It refuses one of another limb.
"""

from collections.abc import Callable

from w2c.clock import Clock
from w2c.errors import DeadlineError, RefusedError
from w2c.messages import EndEffector, Task
from w2c_dialogue import replies
from w2c_dialogue.advice.guard import Guard
from w2c_dialogue.conversation import Conversation, Shown
from w2c_dialogue.frames import RESTARTED, FrameStore
from w2c_dialogue.limbs import Limbs
from w2c_dialogue.outcome import Outcome, goal_of
from w2c_dialogue.outlook import foresee, with_obstacles
from w2c_dialogue.steps import Services


class Confirming:
    """Turns a yes into a goal of the controller. One at a time."""

    def __init__(
        self,
        conversation: Conversation,
        frames: FrameStore,
        guard: Guard,
        limbs: Limbs,
        clock: Clock,
    ) -> None:
        self._conversation = conversation
        self._frames = frames
        self._guard = guard
        self._limbs = limbs
        self._clock = clock

    def confirm(self, target_id: str, services: Services, stopped: Callable[[], bool]) -> Outcome:
        """Send the robot to the target of an id.

        Args:
            target_id: What the operator saw.
            services: Of this turn.
            stopped: Tells whether the operator said stop, or never mind, since the turn began.

        Raises:
            RefusedError: it is not the target on the screen, of a robot that is no more, on the
                veto list, out of reach, or refused by the controller; says which.
        """
        shown = self._conversation.check_confirmation(target_id)
        if not self._frames.current(shown.frame):
            raise RefusedError(RESTARTED)
        if shown.target.point is None:
            shown = self._conversation.lifted(
                services.lift(shown.target.u, shown.target.v, shown.frame)
            )
        with services.steps.measure("veto"):
            unchecked = self._guard.check(shown)
        limb, task, assumed = self._limb(shown, services)
        request = goal_of(self._conversation.next_id("goal"), shown.target, limb, task)
        outlook = foresee(request, services)
        request = with_obstacles(request, self._frames, services)
        if stopped():
            raise RefusedError(
                "You said stop, or took it back, meanwhile: I did not set out. Confirm again to go "
                "there."
            )
        try:
            services.place(request)
        except DeadlineError as error:
            raise RefusedError(
                f"The controller did not answer in time ({error}). It may still move: watch it, "
                "and say stop to hold."
            ) from error
        before = self._conversation.goal
        turns = before is not None and before.effector == limb
        target = self._conversation.confirm(request.goal_id, limb, task, self._clock.now_ns())
        reply = replies.confirmed(
            limb, task, assumed=assumed, outlook=outlook + unchecked, turns=turns
        )
        return Outcome("confirmation", reply, target, self._conversation.goal)

    def _limb(self, shown: Shown, services: Services) -> tuple[EndEffector, Task, str]:
        """Return what goes to a target, what for, and why that limb where none was named."""
        limb, task, assumed = self._limbs.choose(shown, services)
        goal = self._conversation.goal
        if assumed and goal is not None and goal.effector in ("left_hand", "right_hand"):
            return goal.effector, task, "which is on its way"
        return limb, task, "which is on that side" if assumed else ""
