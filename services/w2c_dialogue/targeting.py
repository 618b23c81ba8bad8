"""From words or a click to a target on the screen. Nothing moves here.

While the robot moves, a correction starts from the target it moves to, and keeps its limb.
"""

from collections.abc import Callable

from w2c.errors import CallError, NotNowError, RefusedError
from w2c.messages import LiftReply, PhraseEvidence, PointRequest
from w2c_dialogue import absolute, relative, replies, which
from w2c_dialogue.advice.pointing import MaskedPointing
from w2c_dialogue.analyzer import Analysis, analyze, objects_of_correction
from w2c_dialogue.asking import Asking, which_thing
from w2c_dialogue.conversation import Conversation, Shown
from w2c_dialogue.corrector import CorrectedPoint, correct
from w2c_dialogue.frames import RESTARTED, FrameStore, pixels_per_cm
from w2c_dialogue.interfaces import Frame
from w2c_dialogue.locating import locate
from w2c_dialogue.on_top import says_on_top
from w2c_dialogue.outcome import Outcome
from w2c_dialogue.prompts.base import CorrectionScene, PromptSet
from w2c_dialogue.sight import Prediction, centre, look, only, twins
from w2c_dialogue.steps import Services
from w2c_dialogue.utterance import Utterance

Finish = Callable[[list[PhraseEvidence], Services], Outcome]
"""Goes on with things of which each is one"""


class Targeting:
    """Proposes targets in one conversation, and asks where words leave a choice."""

    def __init__(
        self,
        conversation: Conversation,
        asking: Asking,
        prompts: PromptSet,
        frames: FrameStore,
        masked: MaskedPointing | None,
    ) -> None:
        self._conversation = conversation
        self._asking = asking
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
        absolutely = analysis.position == "absolute"
        mentions = analysis.mentions[:1] if absolutely else analysis.mentions
        evidence = look(services, frame, mentions, "heatmaps" if absolutely else "boxes")
        return self._settle(
            evidence,
            frame,
            lambda settled, then: self._propose(analysis, utterance, frame, settled, then),
            services,
        )

    def _propose(
        self,
        analysis: Analysis,
        utterance: Utterance,
        frame: Frame,
        evidence: list[PhraseEvidence],
        services: Services,
    ) -> Outcome:
        """Show the place that an analysed instruction names among things that are settled."""
        named = ""
        if analysis.position == "absolute":
            named = analysis.mentions[0].phrase
            choose = self._rule(frame, utterance, services)
            on_top = says_on_top(utterance, analysis.mentions[0])
            prediction = absolute.predict(evidence[0], frame, choose, on_top=on_top)
        else:
            prediction = relative.predict(
                services,
                self._prompts,
                frame,
                utterance=utterance,
                mentions=analysis.mentions,
                evidence=evidence,
                grounding=services,
                pixels_per_cm=_scale_at(evidence[0], frame, services),
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
        mentions = objects_of_correction(services, self._prompts, utterance)
        evidence = look(services, frame, mentions, "boxes") if mentions else []

        def move(settled: list[PhraseEvidence], then: Services) -> Outcome:
            now = self._conversation.base()
            if now is None or now.target.target_id != base.target.target_id:
                raise RefusedError("The target changed meanwhile: say the correction again.")
            corrected = correct(
                then,
                self._prompts,
                frame,
                utterance=utterance,
                mentions=mentions,
                evidence=settled,
                scene=scene,
            )
            return self._move(utterance, base, corrected, scene, frame, then)

        return self._settle(evidence, frame, move, services)

    def _move(
        self,
        utterance: Utterance,
        base: Shown,
        corrected: CorrectedPoint,
        scene: CorrectionScene,
        frame: Frame,
        services: Services,
    ) -> Outcome:
        """Show a target at its corrected place."""
        services.trail.corrected_from = scene.target
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

    def _settle(
        self, evidence: list[PhraseEvidence], frame: Frame, finish: Finish, services: Services
    ) -> Outcome:
        """Go on when each phrase means one thing; ask where nothing tells several apart."""
        doubtful = next((i for i, seen in enumerate(evidence) if len(twins(seen)) > 1), None)
        if doubtful is None:
            return finish(evidence, services)
        seen = evidence[doubtful]
        boxes = twins(seen)

        def take(choice: int, then: Services) -> Outcome:
            settled = list(evidence)
            settled[doubtful] = only(seen, boxes[choice], (frame.width, frame.height))
            return self._settle(settled, frame, finish, then)

        def answered(choice: int, then: Services) -> Outcome:
            try:
                self._frames.find(frame.stamp_ns, frame.robot_boot_id)
            except NotNowError as error:
                # The question is about it: it does not come back.
                raise RefusedError(
                    "The picture that I asked about is gone. Name the place again."
                ) from error
            return take(choice, then)

        meant = which.read_phrase(seen.phrase, boxes)
        if meant is not None:
            return take(meant, services)
        return self._asking.ask(which_thing(seen.phrase, boxes, services, answered))

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


def _scale_at(seen: PhraseEvidence, frame: Frame, services: Services) -> float:
    """Return how long a centimetre looks at a thing [px]; the usual length without its depth."""
    view = frame.view
    at = seen.point or next((centre(box) for box in seen.boxes), None)
    if view is None or at is None:
        return pixels_per_cm(None, view)
    try:
        lifted = services.lift(*at, frame)
    except CallError:
        # The place can be shown all the same, and corrected: so does `_depth`, which tells.
        return pixels_per_cm(None, view)
    return pixels_per_cm(lifted.point, view)


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
