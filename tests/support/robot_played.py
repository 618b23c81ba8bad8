"""The services around a dialogue, each on a bus of its own, played by fakes."""

from collections.abc import Sequence
from typing import cast

import numpy as np

from fakes.dialogue_world import GoalTaker, KnownThings, ScriptedModel, TableTop
from w2c import topics
from w2c.bus import InProcessHub
from w2c.bus.codec import Input
from w2c.bus.interface import CallContext
from w2c.clock import StepClock
from w2c.messages import (
    CameraFrame,
    ChooseReply,
    ChooseRequest,
    CompleteReply,
    CompleteRequest,
    ConfirmRequest,
    ControllerStatus,
    GroundingReply,
    GroundingRequest,
    HeightFieldRequest,
    LiftRequest,
    SayRequest,
    StopReply,
    Turn,
)
from w2c_dialogue.interfaces import Frame
from w2c_dialogue.prompts.base import Question, TaskName


def frame_of(request: LiftRequest | HeightFieldRequest) -> Frame:
    """Return the frame that a request names."""
    return Frame(request.frame_stamp_ns, 1280, 720, b"jpeg", robot_boot_id=request.robot_boot_id)


class Robot:
    """The other services on their own buses, played by fakes."""

    def __init__(self) -> None:
        self.hub = InProcessHub()
        self.model = ScriptedModel(
            select=["prediction"],
            analyze=[{"position": "absolute", "objects": ["4-4"]}],
            effector=[{"effector": "right_hand", "task": "contact"}],
        )
        self.grounding = KnownThings(book=(400, 300, 600, 420))
        self.lift = TableTop()
        self.controller = GoalTaker()
        self.buses = {
            name: self.hub.connect(name)
            for name in (
                "llm",
                "grounding",
                "perception",
                "controller",
                "robot",
                "camera",
                "console",
            )
        }
        self.clock = StepClock(1)
        self.ground_inputs: Sequence[Input] = ()
        self._serve()

    def _serve(self) -> None:
        bus = self.buses
        bus["llm"].serve(topics.COMPLETE, lambda request, _: self._complete(request))
        bus["llm"].serve(topics.CHOOSE, lambda request, _: self._choose(request))
        bus["grounding"].serve(topics.GROUND, self._ground)
        bus["perception"].serve(topics.LIFT, lambda r, _: self.lift.lift(r.u, r.v, frame_of(r)))
        bus["perception"].serve(topics.HEIGHT_FIELD, lambda r, _: self.lift.heights(frame_of(r)))
        bus["controller"].serve(topics.PREVIEW, lambda request, _: self.controller.preview(request))
        bus["controller"].serve(topics.PLACE, lambda request, _: self.controller.place(request))
        bus["robot"].serve(topics.ROBOT_STOP, lambda request, _: self._stop(request.reason))

    def _question(self, request: CompleteRequest | ChooseRequest) -> Question:
        messages = tuple(request.messages)
        task = cast(TaskName, messages[0].content)
        return Question(task, messages, 1)

    def _complete(self, request: CompleteRequest) -> CompleteReply:
        value = self.model.complete(self._question(request))
        return CompleteReply(
            text="",
            value=value,
            model="fake",
            prompt_tokens=1,
            reused_tokens=0,
            completion_tokens=1,
            queue_ms=0.0,
            prefill_ms=0.0,
            decode_ms=0.0,
        )

    def _choose(self, request: ChooseRequest) -> ChooseReply:
        choice = self.model.choose(self._question(request), {})
        return ChooseReply(
            option=choice.option,
            probabilities=choice.probabilities,
            model="fake",
            prompt_tokens=1,
            reused_tokens=0,
            queue_ms=0.0,
            prefill_ms=0.0,
        )

    def _ground(self, request: GroundingRequest, context: CallContext) -> GroundingReply:
        self.ground_inputs = context.request.envelope.inputs
        frame = Frame(0, 1280, 720, request.jpeg)
        evidence = self.grounding.ground(frame, request.phrases, request.want)
        return GroundingReply(
            model="fake", width=1280, height=720, evidence=evidence, milliseconds=1.0
        )

    def _stop(self, reason: str) -> StopReply:
        self.controller.stop(reason)
        return StopReply(mode="stopped", stamp_ns=1)

    def say(self, text: str) -> Turn:
        """Say something from the console."""
        return self.buses["console"].call(topics.SAY, SayRequest(text=text)).message

    def confirm(self, target_id: str) -> Turn:
        """Press Confirm on the console."""
        return (
            self.buses["console"].call(topics.CONFIRM, ConfirmRequest(target_id=target_id)).message
        )

    def show(self, stamp_ns: int, robot_boot_id: str = "") -> None:
        """Publish a picture."""
        frame = CameraFrame(
            stamp_ns=stamp_ns,
            frame="camera",
            width=1280,
            height=720,
            intrinsics=(800.0, 800.0, 640.0, 360.0),
            jpeg=b"jpeg",
            depth=b"",
            robot_boot_id=robot_boot_id,
        )
        self.buses["camera"].publish(topics.CAMERA_FRAME, frame)

    def status(self, goal_id: str, message: str = "") -> None:
        """Publish what the controller does."""
        self.buses["controller"].publish(
            topics.CONTROLLER_STATUS,
            ControllerStatus(
                stamp_ns=1,
                tick=1,
                phase="hold",
                goal_id=goal_id,
                in_contact=(True, True, False, False),
                desired_forces=np.zeros((4, 3)),
                end_effector_positions=np.zeros((4, 3)),
                loads=np.zeros(4),
                solver_failures=0,
                lateness_us={},
                tick_us={},
                message=message,
            ),
        )
