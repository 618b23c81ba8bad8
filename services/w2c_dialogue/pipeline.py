"""One turn of the conversation: words, a click or a yes in; a `Turn` out (paper, Fig. 2).

Every failure is a turn with `ok=False` and a reply that says what to do. Nothing moves without a
confirmation that names the target on the screen.
"""

import threading
from collections.abc import Callable

from w2c.clock import Clock
from w2c.errors import CallError, RefusedError, W2CError
from w2c.messages import (
    ConfirmRequest,
    GoalEvent,
    LiftReply,
    PointRequest,
    SayRequest,
    Target,
    Turn,
)
from w2c_dialogue import absolute, relative, replies
from w2c_dialogue.advice.guard import Guard
from w2c_dialogue.advice.pointing import MaskedPointing
from w2c_dialogue.analyzer import analyze
from w2c_dialogue.confirming import Confirming
from w2c_dialogue.conversation import Conversation, Goal, Shown
from w2c_dialogue.corrector import correct
from w2c_dialogue.frames import RESTARTED, FrameStore, pixels_per_cm
from w2c_dialogue.interfaces import Controller, Frame, Grounding, LanguageModel, Lift
from w2c_dialogue.limbs import Limbs
from w2c_dialogue.locating import locate
from w2c_dialogue.outcome import Outcome
from w2c_dialogue.prompts.base import PromptSet
from w2c_dialogue.selector import select
from w2c_dialogue.sight import Prediction
from w2c_dialogue.steps import Services, Steps
from w2c_dialogue.stop_words import is_stop
from w2c_dialogue.utterance import Utterance, parse

FRAME_WAIT_S = 0.5
"""A picture the operator saw, or its camera pose, may still be on its way [s]."""


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
    ) -> None:
        self._model, self._grounding, self._lift, self._controller = (
            model,
            grounding,
            lift,
            controller,
        )
        self._prompts = prompts
        self._frames = frames
        self._masked = masked
        self._clock = clock
        self._conversation = Conversation(prefix)
        self._confirming = Confirming(self._conversation, frames, guard, limbs, clock)
        self._turn = threading.Lock()
        self._stops = 0

    def say(self, request: SayRequest) -> Turn:
        """Answer an utterance."""
        if is_stop(request.text):
            return self._stop(request.text)
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
        """Give up a goal the controller does not know any more; None if it is over already."""
        with self._turn:
            goal = self._conversation.goal
            if goal is None or goal.goal_id != goal_id:
                return None
            target = self._conversation.abandon_goal(reason)
        return self._ended(goal, target)

    def lose_robot(self) -> Turn | None:
        """Give up a target of before the robot started anew; None where there is none."""
        with self._turn:
            shown = self._conversation.shown
            if shown is None or self._frames.current(shown.frame):
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
            if self._conversation.goal is not None:
                outcome = Outcome("none", replies.moving(self._conversation.goal), ok=False)
            else:
                try:
                    outcome = work(services)
                except W2CError as error:
                    outcome = Outcome("none", replies.failure(error, steps.latest), ok=False)
        return self._report(text, outcome, steps)

    def _say(self, request: SayRequest, services: Services) -> Outcome:
        utterance = parse(request.text)
        shown = self._conversation.shown
        selection = select(services, self._prompts, utterance, has_target=shown is not None)
        if selection.module == "confirmation" and not selection.sure:
            return Outcome(
                "none",
                "Did you mean yes? Say 'yes, go there' or press Confirm; or tell me what to "
                "change.",
                ok=False,
            )
        if selection.module == "confirmation":
            return self._confirm(request.target_id, services)
        frame = self._frames.find(request.frame_stamp_ns, request.robot_boot_id, FRAME_WAIT_S)
        if selection.module == "correction" and shown is not None:
            return self._correct(utterance, shown, frame, services)
        return self._predict(utterance, frame, services)

    def _predict(self, utterance: Utterance, frame: Frame, services: Services) -> Outcome:
        analysis = analyze(services, self._prompts, utterance)
        if not analysis.mentions:
            raise RefusedError(
                "I did not hear an object or a place in that, "
                f"and there is {'a' if self._conversation.shown else 'no'} target to confirm or "
                "correct. Name something in the picture, for example: lean on the table with "
                "your right hand."
            )
        named = ""
        if analysis.position == "absolute":
            named = analysis.mentions[0].phrase
            choose = self._rule(frame, utterance, services)
            prediction = absolute.predict(services, frame, analysis.mentions[0], choose)
        else:
            scale = pixels_per_cm(None, frame.view)
            prediction = relative.predict(
                services,
                self._prompts,
                services,
                frame,
                utterance=utterance,
                mentions=analysis.mentions,
                pixels_per_cm=scale,
            )
        lifted, warnings = self._depth(prediction, frame, services)
        target = self._conversation.propose(
            prediction,
            frame,
            instruction=utterance.text,
            lifted=lifted,
            warnings=warnings,
            named=named,
        )
        return Outcome(
            f"prediction.{analysis.position}", replies.proposal(target, analysis.position), target
        )

    def _correct(
        self, utterance: Utterance, shown: Shown, frame: Frame, services: Services
    ) -> Outcome:
        frame, scene = locate(shown, frame)
        corrected = correct(
            services, self._prompts, services, frame, utterance=utterance, scene=scene
        )
        lifted, warnings = self._depth(corrected.prediction, frame, services)
        target = self._conversation.correct(
            corrected.prediction,
            scene,
            frame,
            said=utterance.text,
            lifted=lifted,
            warnings=warnings,
            undo=corrected.undo,
        )
        du, dv = target.u - scene.target[0], target.v - scene.target[1]
        return Outcome("correction", replies.correction(target, du, dv), target)

    def _point(self, request: PointRequest, services: Services) -> Outcome:
        frame = self._frames.find(request.frame_stamp_ns, request.robot_boot_id, FRAME_WAIT_S)
        if not (0 <= request.u <= frame.width and 0 <= request.v <= frame.height):
            raise RefusedError(
                f"({request.u:.0f}, {request.v:.0f}) is outside the picture of "
                f"{frame.width}x{frame.height}."
            )
        shown = self._conversation.shown
        instruction = shown.target.instruction if shown else ""
        prediction = Prediction(request.u, request.v, ())
        lifted, warnings = self._depth(prediction, frame, services)
        target = self._conversation.propose(
            prediction,
            frame,
            instruction=instruction,
            lifted=lifted,
            warnings=warnings,
            effector=request.end_effector,
            task=request.task,
        )
        return Outcome("point", replies.proposal(target, "point"), target)

    def _stop(self, text: str) -> Turn:
        """Hold the robot, whatever else goes on."""
        self._stops += 1
        steps = Steps(self._clock)
        try:
            outcome = Outcome("none", self._controller.stop(f"operator said '{text[:50]}'"))
        except W2CError as error:
            reply = f"STOP WAS NOT ACKNOWLEDGED ({error}). Use the stop button of the robot."
            outcome = Outcome("none", reply, ok=False)
        return self._report(text, outcome, steps)

    # --- helpers ---

    def _confirm(self, target_id: str, services: Services) -> Outcome:
        """Set the robot in motion, unless somebody says stop meanwhile."""
        stops = self._stops
        return self._confirming.confirm(target_id, services, lambda: self._stops != stops)

    def _rule(
        self, frame: Frame, utterance: Utterance, services: Services
    ) -> absolute.Choose | None:
        """Return how a point on a thing is chosen; None: as grounding does."""
        masked = self._masked
        if masked is None:
            return None
        return lambda seen: masked.point(seen, frame, utterance.text, services)

    def _depth(
        self, prediction: Prediction, frame: Frame, services: Services
    ) -> tuple[LiftReply | None, tuple[str, ...]]:
        """Return the world point of a pixel, or why there is none: the target is shown anyway."""
        try:
            return services.lift(prediction.u, prediction.v, frame), ()
        except RefusedError as error:
            return None, (
                f"I cannot tell how far away it is there ({error}): move the target a bit.",
            )
        except CallError as error:
            return None, (f"Perception does not answer ({error}), so I cannot go there yet.",)

    def _ended(self, goal: Goal, target: Target) -> Turn:
        outcome = Outcome(
            "none", replies.arrived(goal, target), target, goal, ok=target.state != "abandoned"
        )
        return self._report("", outcome, Steps(self._clock))

    def _report(self, text: str, outcome: Outcome, steps: Steps) -> Turn:
        return outcome.as_turn(self._clock.now_ns(), text, steps.total(), steps.seconds)
