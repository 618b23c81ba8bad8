"""From words or a click to a target on the screen. Nothing moves here.

While the robot moves, a correction starts from the target it moves to, and keeps its limb.
"""

from w2c.errors import CallError, RefusedError
from w2c.messages import LiftReply, PointRequest
from w2c_dialogue import absolute, relative, replies
from w2c_dialogue.advice.pointing import MaskedPointing
from w2c_dialogue.analyzer import analyze
from w2c_dialogue.conversation import Conversation, Shown
from w2c_dialogue.corrector import correct
from w2c_dialogue.frames import RESTARTED, FrameStore, pixels_per_cm
from w2c_dialogue.interfaces import Frame
from w2c_dialogue.locating import locate
from w2c_dialogue.outcome import Outcome
from w2c_dialogue.prompts.base import PromptSet
from w2c_dialogue.sight import Prediction
from w2c_dialogue.steps import Services
from w2c_dialogue.utterance import Utterance


class Targeting:
    """Proposes targets in one conversation."""

    def __init__(
        self,
        conversation: Conversation,
        prompts: PromptSet,
        frames: FrameStore,
        masked: MaskedPointing | None,
    ) -> None:
        self._conversation = conversation
        self._prompts = prompts
        self._frames = frames
        self._masked = masked

    def predict(self, utterance: Utterance, frame: Frame, services: Services) -> Outcome:
        """Show the place that an instruction names.

        Raises:
            RefusedError: no object was heard, or one is not seen.
            ModelError: the model's answer cannot be followed.
            CallError: a service does not answer.
        """
        analysis = analyze(services, self._prompts, utterance)
        if not analysis.mentions:
            raise RefusedError(
                "I did not hear an object or a place in that, "
                f"and there is {'a' if self._conversation.base() else 'no'} target to confirm or "
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
        lifted, warnings = _depth(prediction, frame, services)
        target = self._conversation.propose(
            prediction,
            frame,
            instruction=utterance.text,
            lifted=lifted,
            warnings=warnings,
            named=named,
        )
        reply = replies.proposal(target, analysis.position) + self._meanwhile()
        return Outcome(f"prediction.{analysis.position}", reply, target)

    def correct(
        self, utterance: Utterance, base: Shown, frame: Frame, services: Services
    ) -> Outcome:
        """Show a target elsewhere.

        Args:
            utterance: What is to change.
            base: The target that it speaks of.
            frame: The picture that the operator saw.
            services: Of this turn.

        Raises:
            RefusedError: the target is of a robot that is no more, not in the picture, or stays
                where it is; an object is not seen.
            ModelError: the model's answer cannot be followed.
            CallError: a service does not answer.
        """
        if not self._frames.current(base.frame):
            raise RefusedError(RESTARTED)
        frame, scene = locate(base, frame)
        corrected = correct(
            services, self._prompts, services, frame, utterance=utterance, scene=scene
        )
        lifted, warnings = _depth(corrected.prediction, frame, services)
        target = self._conversation.correct(
            base,
            corrected.prediction,
            scene,
            frame,
            said=utterance.text,
            lifted=lifted,
            warnings=warnings,
            undo=corrected.undo,
        )
        du, dv = target.u - scene.target[0], target.v - scene.target[1]
        return Outcome("correction", replies.correction(target, du, dv) + self._meanwhile(), target)

    def point(self, request: PointRequest, frame: Frame, services: Services) -> Outcome:
        """Show the place of a click. Raises RefusedError for one outside the picture."""
        if not (0 <= request.u <= frame.width and 0 <= request.v <= frame.height):
            raise RefusedError(
                f"({request.u:.0f}, {request.v:.0f}) is outside the picture of "
                f"{frame.width}x{frame.height}."
            )
        goal = self._conversation.goal
        base = self._conversation.base()
        prediction = Prediction(request.u, request.v, ())
        lifted, warnings = _depth(prediction, frame, services)
        target = self._conversation.propose(
            prediction,
            frame,
            instruction=base.target.instruction if base else "",
            lifted=lifted,
            warnings=warnings,
            effector=request.end_effector or (goal.effector if goal else None),
            task=request.task or (goal.task if goal else None),
        )
        return Outcome("point", replies.proposal(target, "point") + self._meanwhile(), target)

    def _meanwhile(self) -> str:
        goal = self._conversation.goal
        return replies.meanwhile(goal) if goal is not None else ""

    def _rule(
        self, frame: Frame, utterance: Utterance, services: Services
    ) -> absolute.Choose | None:
        """Return how a point on a thing is chosen; None: as grounding does."""
        masked = self._masked
        if masked is None:
            return None
        return lambda seen: masked.point(seen, frame, utterance.text, services)


def _depth(
    prediction: Prediction, frame: Frame, services: Services
) -> tuple[LiftReply | None, tuple[str, ...]]:
    """Return the world point of a pixel, or why there is none: the target is shown anyway."""
    try:
        return services.lift(prediction.u, prediction.v, frame), ()
    except RefusedError as error:
        return None, (f"I cannot tell how far away it is there ({error}): move the target a bit.",)
    except CallError as error:
        return None, (f"Perception does not answer ({error}), so I cannot go there yet.",)
