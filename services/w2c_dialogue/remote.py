"""The other services, behind the interfaces of this one. Each call has a deadline and a trace."""

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import msgspec

from w2c import topics
from w2c.bus import Bus
from w2c.errors import RefusedError, W2CError
from w2c.messages import (
    AllowedArea,
    AllowedAreaRequest,
    ChooseRequest,
    CompleteRequest,
    GoalReply,
    GroundingReply,
    GroundingRequest,
    HeightField,
    HeightFieldRequest,
    LiftReply,
    LiftRequest,
    PhraseEvidence,
    PlaceGoal,
    PreviewReply,
    StopRequest,
)
from w2c_dialogue.interfaces import Choice, Frame
from w2c_dialogue.prompts.base import Question

PREVIEW_TIMEOUT_S = 2.0
"""Most take a twentieth of a second; the goal goes without where none comes."""


class RemoteServices:
    """Language model, grounding, perception and controller over the bus."""

    def __init__(self, bus: Bus, *, seed: int, model_timeout_s: float) -> None:
        self._bus = bus
        self._seed = seed
        self._timeout_s = model_timeout_s
        self.language_model = ""
        """Name of the model that answered last"""
        self.vision_model = ""
        """Name of the model that looked last"""

    def complete(self, question: Question) -> Any:
        """Ask the language model for JSON."""
        request = CompleteRequest(
            messages=list(question.messages),
            schema=question.schema or {},
            seed=self._seed,
            constant_messages=question.constant_messages,
            deadline=self._timeout_s,
        )
        reply = self._bus.call(topics.COMPLETE, request, timeout_s=self._timeout_s).message
        self.language_model = reply.model
        return reply.value

    def choose(self, question: Question, log_prior: Mapping[str, float]) -> Choice:
        """Ask the language model for an option."""
        request = ChooseRequest(
            messages=list(question.messages),
            options=list(question.options),
            log_prior=dict(log_prior),
            constant_messages=question.constant_messages,
            deadline=self._timeout_s,
        )
        reply = self._bus.call(topics.CHOOSE, request, timeout_s=self._timeout_s).message
        self.language_model = reply.model
        return Choice(reply.option, reply.probabilities)

    def ground(
        self, frame: Frame, phrases: Sequence[str], want: Literal["heatmaps", "boxes"]
    ) -> list[PhraseEvidence]:
        """Look for phrases in a picture."""
        request = GroundingRequest(jpeg=frame.jpeg, phrases=list(phrases), want=want)
        return self._ground(frame, request).evidence

    def find(self, frame: Frame, phrases: Sequence[str]) -> GroundingReply:
        """Look for phrases in a picture, with heatmaps; says which model looked."""
        request = GroundingRequest(jpeg=frame.jpeg, phrases=list(phrases), want="heatmaps")
        return self._ground(frame, request)

    def lift(self, u: float, v: float, frame: Frame) -> LiftReply:
        """Find the point of the world behind a pixel."""
        request = LiftRequest(
            u=u, v=v, frame_stamp_ns=frame.stamp_ns, robot_boot_id=frame.robot_boot_id
        )
        return self._bus.call(topics.LIFT, request).message

    def allowed(self, frame: Frame) -> AllowedArea:
        """Find where in a frame a hand may go."""
        request = AllowedAreaRequest(
            frame_stamp_ns=frame.stamp_ns, robot_boot_id=frame.robot_boot_id
        )
        return self._bus.call(topics.FIND_ALLOWED_AREA, request).message

    def heights(self, frame: Frame) -> HeightField:
        """Find how high things stand in a frame."""
        request = HeightFieldRequest(
            frame_stamp_ns=frame.stamp_ns, robot_boot_id=frame.robot_boot_id
        )
        return self._bus.call(topics.HEIGHT_FIELD, request).message

    def preview(self, goal: PlaceGoal) -> PreviewReply:
        """Find how a goal would end, without obstacles: a preview knows nothing of ways."""
        request = msgspec.structs.replace(goal, obstacles=None)
        return self._bus.call(topics.PREVIEW, request, timeout_s=PREVIEW_TIMEOUT_S).message

    def place(self, goal: PlaceGoal) -> GoalReply:
        """Set the robot in motion."""
        return self._bus.call(topics.PLACE, goal).message

    def stop(self, reason: str) -> str:
        """Hold the robot: its driver first, which needs nobody else, then the controller.

        Raises:
            RefusedError: the driver did not acknowledge; says whether the controller did.
        """
        request = StopRequest(reason=reason)
        try:
            mode = self._bus.call(topics.ROBOT_STOP, request).message.mode
        except W2CError as error:
            raise RefusedError(f"{error}; {self._stop_controller(request)}") from error
        controller = self._stop_controller(request)
        return f"The robot holds ({mode}); {controller}. `w2c resume` lets it move again."

    def _ground(self, frame: Frame, request: GroundingRequest) -> GroundingReply:
        inputs = [frame.source] if frame.source else []
        reply = self._bus.call(
            topics.GROUND, request, timeout_s=self._timeout_s, inputs=inputs
        ).message
        self.vision_model = reply.model
        return reply

    def _stop_controller(self, request: StopRequest) -> str:
        try:
            self._bus.call(topics.CONTROLLER_STOP, request)
        except W2CError as error:
            return f"the controller did not acknowledge ({error})"
        return "the controller knows"
