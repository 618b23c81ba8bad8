"""A scripted operator: says a line, waits for what comes of it, and measures it."""

import time
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from w2c import topics
from w2c.bus import Bus
from w2c.errors import W2CError
from w2c.geometry import Vector
from w2c.messages import (
    CameraFrame,
    ControllerStatus,
    GoalEvent,
    PictureRequest,
    RobotDescription,
    SayRequest,
    Target,
    Truth,
    Turn,
)
from w2c_evaluation.demo.answers import answer_for
from w2c_evaluation.demo.scenario import Line
from w2c_evaluation.scenarios.answering import MOST_QUESTIONS, read_question

FINAL_STATES = {"loaded", "reached", "unreachable", "released", "aborted"}
END_EFFECTORS = ("left_foot", "right_foot", "left_hand", "right_hand")
MOTION_PATIENCE_S = 180.0
MOST_REPETITIONS = 2
"""Of a line that the robot asks for again: a service was late, as on a crowded machine"""
REACH_STANDOFF_M = 0.02
"""Off the surface is where a reaching hand shall come, along the normal"""
SETTLE_S = 3.0
"""Robot time that the hand's load is watched after it was reported"""


class ScenarioError(W2CError):
    """The scenario did not go as it must; says at which line and why."""

    code = "scenario"


@dataclass
class LineResult:
    """What one line of the scenario gave."""

    turn: Turn
    event: GoalEvent | None = None
    error_m: float = float("nan")
    """Between the hand's true position and where it should be"""
    force_n: float = float("nan")
    """What the environment truly exerts on the hand, along the surface normal"""


class Operator:
    """Talks to the running system as a person would, through the bus."""

    def __init__(
        self, bus: Bus, description: RobotDescription, places: Mapping[str, Vector]
    ) -> None:
        """Begin to listen.

        Args:
            bus: Of the evaluation.
            description: Of the robot.
            places: Points (3,) of the things that lines mean, in the world [m].
        """
        self._bus = bus
        self._description = description
        self._places = places
        self._events = bus.queue(topics.GOAL_EVENT)
        self._targets = bus.queue(topics.TARGET)
        self._truth = bus.queue(topics.TRUTH, size=20_000)
        self._status = bus.latest(topics.CONTROLLER_STATUS)
        self._frames = bus.latest(topics.CAMERA_FRAME)
        self._views = bus.latest(topics.CAMERA_VIEW)
        self.target: Target | None = None
        self.fell = False

    def wait_until_it_stands(self, patience_s: float = 120.0) -> None:
        """Return when the controller holds and a picture can be lifted. Raises ScenarioError."""
        deadline = time.monotonic() + patience_s
        while time.monotonic() < deadline:
            status = self._status.wait(0.5)
            if status is not None and status.message.phase == "hold" and self._views.last():
                return
        raise ScenarioError("the robot does not stand, or the camera gives no picture")

    def perform(self, line: Line) -> LineResult:
        """Say a line and wait for its end. Raises ScenarioError."""
        turn = self._say(line.text, line)
        for _ in range(MOST_REPETITIONS):
            if not turn.retryable:
                break
            turn = self._say(line.text, line)
        if turn.options and line.again:
            turn = self._say(line.again, line)
        if not turn.ok:
            raise ScenarioError(f"'{line.text}' was answered with: {turn.reply}")
        if turn.target is not None:
            self.target = turn.target
        if line.expect == "target":
            if turn.target is None:
                raise ScenarioError(f"'{line.text}' proposed no target: {turn.reply}")
            return LineResult(turn)
        if not turn.goal_id:
            raise ScenarioError(f"'{line.text}' started no motion: {turn.reply}")
        result = LineResult(turn, self._wait_for_end(turn))
        self._measure(result)
        self.target = None
        return result

    def _say(self, text: str, line: Line) -> Turn:
        """Say a line in these words, and answer what is asked back; returns the last answer."""
        turn = self._tell(text)
        for _ in range(MOST_QUESTIONS):
            question, view = read_question(turn), self._views.last()
            if question is None or view is None:
                break
            answer = answer_for(question, line, self._places, view.message)
            if answer is None:
                break
            turn = self._tell(answer)
        return turn

    def _tell(self, text: str) -> Turn:
        frame = self._frames.last()
        request = SayRequest(
            text=text,
            frame_stamp_ns=-1 if frame is None else frame.message.stamp_ns,
            target_id="" if self.target is None else self.target.target_id,
        )
        return self._bus.call(topics.SAY, request).message

    def take_picture(self, view: str) -> bytes:
        """Return a JPEG of the robot from outside."""
        request = PictureRequest(view="front" if view == "front" else "side")
        return self._bus.call(topics.PICTURE, request).message.jpeg

    def frame_of_target(self) -> CameraFrame | None:
        """Return the newest frame of the head camera."""
        frame = self._frames.last()
        return None if frame is None else frame.message

    def status(self) -> ControllerStatus:
        """Return the controller's newest status. Raises ScenarioError."""
        status = self._status.last()
        if status is None:
            raise ScenarioError("the controller reports no status")
        return status.message

    def _wait_for_end(self, turn: Turn) -> GoalEvent:
        deadline = time.monotonic() + MOTION_PATIENCE_S
        while (remaining := deadline - time.monotonic()) > 0:
            received = self._events.receive(min(remaining, 0.5))
            self._watch_truth()
            if received is None or received.message.goal_id != turn.goal_id:
                continue
            event = received.message
            if event.state in ("loaded", "reached"):
                return event
            if event.state in FINAL_STATES:
                raise ScenarioError(f"'{turn.text}': {event.state}: {event.reason}")
        raise ScenarioError(f"'{turn.text}': no end within {MOTION_PATIENCE_S:.0f} s")

    def _measure(self, result: LineResult) -> None:
        """Watch the truth for a while, then compare the hand with where it should be."""
        if self.target is None or self.target.point is None or self.target.normal is None:
            raise ScenarioError("the confirmed target has no point in the world")
        if result.event is None:
            raise ScenarioError("a motion without an end cannot be measured")
        index = END_EFFECTORS.index(result.event.end_effector)
        radius = self._description.hand_radius[index - 2] if index >= 2 else 0.0
        away = radius + (REACH_STANDOFF_M if result.event.task == "reach" else 0.0)
        should: Vector = self.target.point + away * self.target.normal
        forces: list[float] = []
        first = last = self._next_truth()
        while (last.stamp_ns - first.stamp_ns) * 1e-9 < SETTLE_S:
            last = self._next_truth()
            forces.append(float(last.contact_forces[index] @ self.target.normal))
        result.error_m = float(np.linalg.norm(last.end_effector_positions[index] - should))
        result.force_n = float(np.median(forces))

    def _next_truth(self) -> Truth:
        received = self._truth.receive(20.0)
        if received is None:
            raise ScenarioError("the simulator stopped telling the truth: is it still running?")
        self.fell = self.fell or received.message.fell
        return received.message

    def _watch_truth(self) -> None:
        while (received := self._truth.receive(0.0)) is not None:
            self.fell = self.fell or received.message.fell
