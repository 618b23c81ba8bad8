"""From a confirmed target to a robot that moves: everything that is asked before it does."""

from collections.abc import Callable

from w2c.clock import Clock
from w2c.errors import DeadlineError, RefusedError
from w2c_dialogue import replies
from w2c_dialogue.advice.guard import Guard
from w2c_dialogue.conversation import Conversation
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
            stopped: Tells whether the operator said stop since the turn began.

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
        limb, task, assumed = self._limbs.choose(shown, services)
        request = goal_of(self._conversation.next_id("goal"), shown.target, limb, task)
        outlook = foresee(request, services)
        request = with_obstacles(request, self._frames, services)
        if stopped():
            raise RefusedError(
                "You said stop meanwhile; I did not move. Confirm again to go there."
            )
        try:
            services.place(request)
        except DeadlineError as error:
            raise RefusedError(
                f"The controller did not answer in time ({error}). It may still move: watch it, "
                "and say stop to hold."
            ) from error
        target = self._conversation.confirm(request.goal_id, limb, task, self._clock.now_ns())
        reply = replies.confirmed(limb, task, assumed=assumed, outlook=outlook + unchecked)
        return Outcome("confirmation", reply, target, self._conversation.goal)
