"""Bus in, bus out: serves `say`, `confirm` and `point`, publishes the target and every turn."""

import logging
import threading
from collections.abc import Callable
from typing import Any, TypeVar

from w2c import topics
from w2c.bus import Bus
from w2c.bus.interface import CallContext, Queue, Received
from w2c.clock import Clock
from w2c.messages import (
    Advice,
    AllowedArea,
    CameraFrame,
    CameraView,
    ConfirmRequest,
    GoalEvent,
    Message,
    PointRequest,
    SayRequest,
    Target,
    Turn,
)
from w2c_dialogue.advice.advisor import Advisor
from w2c_dialogue.advice.checks import Checks
from w2c_dialogue.advice.guard import Guard
from w2c_dialogue.advice.pointing import MaskedPointing
from w2c_dialogue.advice.points import PointVeto
from w2c_dialogue.advice.veto import unknown_text
from w2c_dialogue.advice.watch import Watch
from w2c_dialogue.advice.wordlist import check_phrases
from w2c_dialogue.config import DialogueConfig
from w2c_dialogue.frames import FrameStore
from w2c_dialogue.interfaces import Frame
from w2c_dialogue.limbs import Limbs
from w2c_dialogue.pipeline import Dialogue
from w2c_dialogue.prompts.sets import make_prompts
from w2c_dialogue.remote import RemoteServices

_LOG = logging.getLogger("w2c.dialogue")
M = TypeVar("M", bound=Message)

POLL_S = 0.2
"""How long a thread waits for a message before it looks for the end."""
REPEAT_S = 0.5
"""The present target and its advice are repeated, for who joins later."""
FRAME_QUEUE = 8
"""Every picture may be the one the operator saw; a few may wait while the process is busy."""
WORKERS = 4
"""One turn at a time, but `stop` must not wait behind it."""


class DialogueNode:
    """The conversation as a process."""

    def __init__(self, config: DialogueConfig, bus: Bus, clock: Clock) -> None:
        self._config = config
        self._bus = bus
        self._clock = clock
        self._frames = FrameStore()
        services = RemoteServices(bus, seed=config.seed, model_timeout_s=config.model_timeout)
        hasty = RemoteServices(bus, seed=config.seed, model_timeout_s=config.advice_timeout)
        watched = check_phrases((*config.veto, *config.fragile))
        self._watch = Watch(hasty.find, watched, config.advice_timeout)
        self._guard = Guard(
            self._watch,
            config.veto,
            share=config.veto_share,
            margin=config.veto_margin,
            unchecked=config.unchecked_veto,
        )
        prompts = make_prompts(config.prompts, config.answers)
        limbs = Limbs(prompts)
        masked = MaskedPointing(
            self._guard, limbs, self._show_area, clock, budget_s=config.pointing_budget
        )
        self._dialogue = Dialogue(
            services,
            services,
            services,
            services,
            prompts=prompts,
            frames=self._frames,
            guard=self._guard,
            limbs=limbs,
            masked=masked if config.masked_pointing else None,
            clock=clock,
            prefix=bus.boot_id[:6],
            ask_margin=config.ask_margin,
        )
        checks = Checks(
            self._guard,
            self._watch,
            limbs,
            hasty,
            hasty,
            fragile=config.fragile,
            share=config.veto_share,
        )
        self._advisor = Advisor(
            checks, self._advise, self._shown_id, clock, deadline_s=config.advice_timeout
        )
        self._limbs, self._hasty = limbs, hasty
        self._advice: Advice | None = None
        self._target: Target | None = None
        self._stop = threading.Event()
        self._threads: list[threading.Thread] = []

    @property
    def detail(self) -> str:
        """Which no-go phrases nobody looks for; shown in the health."""
        unknown = self._watch.unknown
        lost = tuple(phrase for phrase in self._config.veto if phrase in unknown)
        return f"veto list: {unknown_text(lost)}" if lost else ""

    def configure(self) -> None:
        """Subscribe and serve."""
        self._status = self._bus.latest(topics.CONTROLLER_STATUS)
        self._pump(self._bus.queue(topics.CAMERA_FRAME, FRAME_QUEUE), self.on_frame, "frames")
        self._pump(self._bus.queue(topics.CAMERA_VIEW), self.on_view, "views")
        self._pump(self._bus.queue(topics.GOAL_EVENT), self.on_goal_event, "goals")
        self._advisor.start()
        self._bus.serve(topics.SAY, self.say, workers=WORKERS)
        self._bus.serve(topics.CONFIRM, self.confirm, workers=WORKERS)
        self._bus.serve(topics.POINT, self.point, workers=WORKERS)
        self._bus.serve(topics.VETO, PointVeto(self._guard, self._frames).answer)

    def run(self, stop: threading.Event) -> None:
        """Repeat the target and watch over the goal until the end."""
        while not stop.wait(REPEAT_S):
            if self._target is not None:
                self._bus.publish(topics.TARGET, self._target)
            advice = self._advice
            if advice is not None and advice.target_id == self._shown_id():
                self._bus.publish(topics.ADVICE, advice)
            self.check_robot()
            self.check_goal()

    def close(self) -> None:
        """End the threads."""
        self._stop.set()
        self._advisor.close()
        for thread in self._threads:
            thread.join(timeout=2.0)

    def say(self, request: SayRequest, context: CallContext) -> Turn:
        """Answer an utterance."""
        return self._publish(self._dialogue.say(request), context.request)

    def confirm(self, request: ConfirmRequest, context: CallContext) -> Turn:
        """Answer the Confirm button."""
        return self._publish(self._dialogue.confirm(request), context.request)

    def point(self, request: PointRequest, context: CallContext) -> Turn:
        """Answer a click."""
        return self._publish(self._dialogue.point(request), context.request)

    def check_robot(self) -> None:
        """Give up a target of before the robot started anew."""
        turn = self._dialogue.lose_robot()
        if turn is not None:
            self._publish(turn)

    def check_goal(self) -> None:
        """Give up a goal that the controller does not know any more: it may have been restarted."""
        goal = self._dialogue.goal()
        silence = self._config.goal_silence
        if goal is None or (self._clock.now_ns() - goal.since_ns) * 1e-9 < silence:
            return
        status = self._status.last()
        if status is None or self._status.age_s() > silence:
            reason = "the controller does not report"
        elif status.message.goal_id != goal.goal_id:
            reason = status.message.message or "the controller does not follow it any more"
        else:
            return
        self.give_up(goal.goal_id, reason)

    def give_up(self, goal_id: str, reason: str) -> None:
        """Give up a goal for a reason, unless it is over already."""
        turn = self._dialogue.lose_goal(goal_id, reason)
        if turn is not None:
            self._publish(turn)

    def on_frame(self, received: Received[CameraFrame]) -> None:
        """Keep a picture."""
        message = received.message
        source = received.as_input()
        self._frames.add_frame(
            Frame(
                message.stamp_ns,
                message.width,
                message.height,
                message.jpeg,
                source=source,
                robot_boot_id=message.robot_boot_id,
            )
        )

    def on_view(self, received: Received[CameraView]) -> None:
        """Keep where the camera was."""
        self._frames.add_view(received.message)

    def on_goal_event(self, received: Received[GoalEvent]) -> None:
        """Follow the robot."""
        turn = self._dialogue.follow(received.message)
        if turn is not None:
            self._publish(turn, received)

    def hear_limb(self) -> None:
        """Find out which limb the shown target is for, as advice does beside the turns.

        Raises CallError, ModelError.
        """
        shown = self._dialogue.shown()
        if shown is not None and shown.target.instruction:
            self._limbs.hear(shown.target.instruction, self._hasty)

    def _publish(self, turn: Turn, cause: Received[Any] | None = None) -> Turn:
        inputs = [cause.as_input()] if cause else []
        shown = self._dialogue.shown()
        if turn.target is not None:
            self._target = turn.target
            self._bus.publish(topics.TARGET, turn.target, inputs)
            if shown is not None and shown.target is turn.target:
                self._advisor.consider(shown)
            elif shown is not None:
                # What the robot did or gave up must not hide what waits for a yes.
                self._target = shown.target
                self._bus.publish(topics.TARGET, shown.target, inputs)
        self._bus.publish(topics.TURN, turn, inputs)
        _LOG.info(
            "turn", extra={"module_name": turn.module, "ok": turn.ok, "seconds": turn.seconds}
        )
        return turn

    def _advise(self, advice: Advice) -> None:
        self._advice = advice
        self._bus.publish(topics.ADVICE, advice)

    def _show_area(self, area: AllowedArea) -> None:
        self._bus.publish(topics.ALLOWED_AREA, area)

    def _shown_id(self) -> str:
        shown = self._dialogue.shown()
        return shown.target.target_id if shown else ""

    def _pump(self, queue: Queue[M], handle: Callable[[Received[M]], None], name: str) -> None:
        """Hand every message of a queue to a handler, on a thread of its own."""

        def work() -> None:
            while not self._stop.is_set():
                received = queue.receive(POLL_S)
                if received is not None:
                    handle(received)

        thread = threading.Thread(target=work, name=name, daemon=True)
        self._threads.append(thread)
        thread.start()
