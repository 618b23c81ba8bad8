"""One turn of the conversation: words, a click or a yes in; a `Turn` out (paper, Fig. 2).

Every failure is a turn with `ok=False` and a reply that says what to do. Nothing moves without a
confirmation that names the target on the screen, and a robot that moves turns nowhere else without
one. Stop and cancel words need no model.
"""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from w2c.clock import Clock
from w2c.errors import RefusedError, W2CError
from w2c.messages import (
    ConfirmRequest,
    Evidence,
    GoalEvent,
    PointRequest,
    SayRequest,
    Target,
    Turn,
)
from w2c_dialogue import replies
from w2c_dialogue.advice.guard import Guard
from w2c_dialogue.advice.pointing import MaskedPointing
from w2c_dialogue.asking import Asking, which_module
from w2c_dialogue.cancel_words import is_cancel
from w2c_dialogue.confirming import Confirming
from w2c_dialogue.conversation import Conversation, Goal, Shown
from w2c_dialogue.frames import RESTARTED, FrameStore
from w2c_dialogue.interfaces import Controller, Frame, Grounding, LanguageModel, Lift
from w2c_dialogue.limbs import Limbs
from w2c_dialogue.outcome import Outcome
from w2c_dialogue.prompts.base import PromptSet
from w2c_dialogue.selector import select
from w2c_dialogue.steps import Services, Steps
from w2c_dialogue.stop_words import begins_with_stop, is_stop
from w2c_dialogue.targeting import Targeting
from w2c_dialogue.utterance import Utterance, parse
from w2c_dialogue.yes_but import asks_for_more

FRAME_WAIT_S = 2.0
"""A picture the operator saw, or its camera pose, may still be on its way, on a slow machine
[s]."""


class Dialogue:
    """The modules of the paper around one conversation.

    Thread-safe. One turn at a time; only stop never waits.
    """

    def __init__(
        self,
        model: LanguageModel,
        grounding: Grounding,
        lift: Lift,
        controller: Controller,
        *,
        prompts: PromptSet,
        frames: FrameStore,
        guard: Guard,
        limbs: Limbs,
        masked: MaskedPointing | None = None,
        clock: Clock,
        prefix: str,
        ask_margin: float = 0.2,
    ) -> None:
        self._model, self._grounding, self._lift, self._controller = (
            model,
            grounding,
            lift,
            controller,
        )
        self._prompts = prompts
        self._frames = frames
        self._clock = clock
        self._conversation = Conversation(prefix)
        self._asking = Asking()
        self._ask_margin = ask_margin
        self._targeting = Targeting(self._conversation, self._asking, prompts, frames, masked)
        self._confirming = Confirming(self._conversation, frames, guard, limbs, clock)
        self._turn = threading.Lock()
        self._stops = 0

    def say(self, request: SayRequest) -> Turn:
        """Answer an utterance."""
        cancels = is_cancel(request.text)
        moves = self._conversation.goal is not None
        if is_stop(request.text) or (moves and begins_with_stop(request.text)):
            return self._stop(request.text)
        if cancels and self._moves_only():
            return self._stop(request.text)
        if cancels:
            self._stops += 1  # A confirmation that is being made is not to move any more.
            return self._take_turn(request.text, lambda _: self._cancel(request.text))
        return self._take_turn(request.text, lambda services: self._say(request, services))

    def confirm(self, request: ConfirmRequest) -> Turn:
        """Answer the Confirm button."""
        return self._take_turn("", lambda services: self._confirm(request.target_id, services))

    def point(self, request: PointRequest) -> Turn:
        """Answer a click into the picture."""
        return self._take_turn("", lambda services: self._point(request, services))

    def follow(self, event: GoalEvent) -> Turn | None:
        """Follow the robot. Returns a turn when the goal of this conversation is over."""
        with self._turn:
            over = self._conversation.progress(event, self._clock.now_ns())
        return None if over is None else self._ended(*over)

    def lose_goal(self, goal_id: str, reason: str) -> Turn | None:
        """Give up a goal the controller does not know any more; None if it is over already.

        None, too, while a turn is taken: what happened to the goal may wait behind it. Ask again.
        """
        with self._unless_busy() as free:
            goal = self._conversation.goal
            if not free or goal is None or goal.goal_id != goal_id:
                return None
            target = self._conversation.abandon_goal(reason)
        return self._ended(goal, target)

    def lose_robot(self) -> Turn | None:
        """Give up a target of before the robot started anew; None where there is none, or later."""
        with self._unless_busy() as free:
            shown = self._conversation.shown
            if not free or shown is None or self._frames.current(shown.frame):
                return None
            target = self._conversation.abandon_shown(RESTARTED)
        return self._report("", Outcome("none", RESTARTED, target, ok=False), Steps(self._clock))

    def goal(self) -> Goal | None:
        """Return the goal under way."""
        return self._conversation.goal

    def shown(self) -> Shown | None:
        """Return the target on the screen."""
        return self._conversation.shown

    # --- turns ---

    def _take_turn(self, text: str, work: Callable[[Services], Outcome]) -> Turn:
        steps = Steps(self._clock)
        services = Services(self._model, self._grounding, self._lift, self._controller, steps)
        with self._turn:
            asked = self._asking.pending
            try:
                outcome = work(services)
            except W2CError as error:
                reply = replies.failure(error, steps.latest)
                outcome = Outcome("none", reply, ok=False, retryable=error.retryable)
            outcome = self._asking.settle(outcome, asked)
        return self._report(text, outcome, steps, services.trail.evidence(self._prompts.name))

    def _say(self, request: SayRequest, services: Services) -> Outcome:
        utterance = parse(request.text)
        answered = self._asking.answer(utterance, services)
        if answered is not None:
            return answered
        has_target = self._conversation.base() is not None
        selection = select(services, self._prompts, utterance, has_target=has_target)
        unsure = has_target and selection.margin < self._ask_margin
        perhaps_yes = unsure and selection.next_best == "confirmation"
        says_yes = selection.module == "confirmation"
        if perhaps_yes or (says_yes and (not selection.sure or asks_for_more(utterance))):
            return Outcome(
                "none",
                "Did you mean yes? Say 'yes, go there' or press Confirm; or tell me what to "
                "change.",
                ok=False,
            )
        if says_yes and self._asking.pending is not None and self._conversation.shown is not None:
            raise RefusedError(
                "I asked you something, so I do not take that for a yes to the target shown. Press "
                "Confirm to go there all the same."
            )
        if says_yes:
            return self._confirm(request.target_id, services)
        frame = self._frames.find(request.frame_stamp_ns, request.robot_boot_id, FRAME_WAIT_S)
        if unsure:
            return self._asking.ask(
                which_module(
                    services,
                    lambda choice, then: self._understand(choice == 1, utterance, frame, then),
                )
            )
        return self._understand(selection.module == "correction", utterance, frame, services)

    def _understand(
        self, corrects: bool, utterance: Utterance, frame: Frame, services: Services
    ) -> Outcome:
        """Show what an instruction or a correction means."""
        base = self._conversation.base()
        if corrects and base is not None:
            return self._targeting.correct(utterance, base, frame, services)
        return self._targeting.predict(utterance, frame, services)

    def _point(self, request: PointRequest, services: Services) -> Outcome:
        frame = self._frames.find(request.frame_stamp_ns, request.robot_boot_id, FRAME_WAIT_S)
        return self._targeting.point(request, frame, services)

    def _cancel(self, text: str) -> Outcome:
        """Drop the target on the screen; a motion to another one goes on."""
        if self._moves_only():
            return self._hold(text)
        if self._conversation.shown is None and self._asking.pending is not None:
            return Outcome("cancel", replies.dropped(self._conversation.goal, question=True))
        if self._conversation.shown is None:
            raise RefusedError("There is no target to forget. Nothing moves.")
        target = self._conversation.abandon_shown("you took it back")
        return Outcome("cancel", replies.dropped(self._conversation.goal), target)

    def _stop(self, text: str) -> Turn:
        """Hold the robot, whatever else goes on."""
        self._stops += 1
        steps = Steps(self._clock)
        return self._report(text, self._hold(text), steps)

    def _hold(self, text: str) -> Outcome:
        try:
            return Outcome("none", self._controller.stop(f"operator said '{text[:50]}'"))
        except W2CError as error:
            reply = f"STOP WAS NOT ACKNOWLEDGED ({error}). Use the stop button of the robot."
            return Outcome("none", reply, ok=False)

    # --- helpers ---

    @contextmanager
    def _unless_busy(self) -> Iterator[bool]:
        """Yield whether no turn is taken, and let none begin meanwhile."""
        free = self._turn.acquire(blocking=False)
        try:
            yield free
        finally:
            if free:
                self._turn.release()

    def _moves_only(self) -> bool:
        """Say whether the motion is the only thing that could be taken back."""
        waits = self._conversation.shown is not None or self._asking.pending is not None
        return self._conversation.goal is not None and not waits

    def _confirm(self, target_id: str, services: Services) -> Outcome:
        """Set the robot in motion, unless somebody says stop meanwhile."""
        stops = self._stops
        return self._confirming.confirm(target_id, services, lambda: self._stops != stops)

    def _ended(self, goal: Goal, target: Target) -> Turn:
        reply = replies.arrived(goal, target, shown=self._conversation.shown is not None)
        outcome = Outcome("none", reply, target, goal, ok=target.state != "abandoned")
        return self._report("", outcome, Steps(self._clock))

    def _report(
        self, text: str, outcome: Outcome, steps: Steps, evidence: Evidence | None = None
    ) -> Turn:
        now_ns = self._clock.now_ns()
        state = self._conversation.state
        return outcome.as_turn(
            now_ns, text, steps.total(), steps.seconds, state=state, evidence=evidence
        )
