"""Where the time of a turn goes, at which step it failed, and what was answered on the way."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, Literal

from w2c.clock import Clock
from w2c.messages import (
    AllowedArea,
    GoalReply,
    HeightField,
    LiftReply,
    PhraseEvidence,
    PlaceGoal,
    PreviewReply,
)
from w2c_dialogue.interfaces import Choice, Controller, Frame, Grounding, LanguageModel, Lift
from w2c_dialogue.prompts.base import Question
from w2c_dialogue.trail import Trail

STEP_OF_TASK = {
    "select": "selector",
    "analyze": "analyzer",
    "objects": "analyzer",
    "relative": "relative",
    "correct": "correction",
    "effector": "effector",
}


class Steps:
    """Seconds spent in each step of one turn."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._start_ns = clock.now_ns()
        self.seconds: dict[str, float] = {}
        self.latest = ""
        """The step that began last: the one that failed, when one did."""

    def total(self) -> float:
        """Return the time since the turn began [s]."""
        return (self._clock.now_ns() - self._start_ns) * 1e-9

    @contextmanager
    def measure(self, step: str) -> Iterator[None]:
        """Add the time of the block to a step."""
        self.latest = step
        start_ns = self._clock.now_ns()
        try:
            yield
        finally:
            spent = (self._clock.now_ns() - start_ns) * 1e-9
            self.seconds[step] = self.seconds.get(step, 0.0) + spent


class Services:
    """The language model, grounding, lift and controller of one turn, timed and remembered."""

    def __init__(
        self,
        model: LanguageModel,
        grounding: Grounding,
        lift: Lift,
        controller: Controller,
        steps: Steps,
    ) -> None:
        self._model, self._grounding, self._lift, self._controller = (
            model,
            grounding,
            lift,
            controller,
        )
        self._steps = steps
        self.trail = Trail()
        """What they answered"""

    @property
    def steps(self) -> Steps:
        """The stopwatch."""
        return self._steps

    @property
    def language_model(self) -> str:
        """Name of the model that answered last."""
        return self._model.language_model

    @property
    def vision_model(self) -> str:
        """Name of the model that looked last."""
        return self._grounding.vision_model

    def complete(self, question: Question) -> Any:
        """Ask the language model for JSON."""
        with self._steps.measure(STEP_OF_TASK[question.task]):
            value = self._model.complete(question)
        self.trail.wrote(question.task, value, self._model.language_model)
        return value

    def choose(self, question: Question, log_prior: Mapping[str, float]) -> Choice:
        """Ask the language model for an option."""
        with self._steps.measure(STEP_OF_TASK[question.task]):
            choice = self._model.choose(question, log_prior)
        self.trail.chose(question.task, choice, self._model.language_model)
        return choice

    def ground(
        self, frame: Frame, phrases: Sequence[str], want: Literal["heatmaps", "boxes"]
    ) -> list[PhraseEvidence]:
        """Look for phrases."""
        with self._steps.measure("grounding"):
            evidence = self._grounding.ground(frame, phrases, want)
        self.trail.saw(evidence, self._grounding.vision_model)
        return evidence

    def lift(self, u: float, v: float, frame: Frame) -> LiftReply:
        """Find the depth of a pixel."""
        with self._steps.measure("lift"):
            return self._lift.lift(u, v, frame)

    def allowed(self, frame: Frame) -> AllowedArea:
        """Find where in a frame a hand may go."""
        with self._steps.measure("allowed"):
            return self._lift.allowed(frame)

    def heights(self, frame: Frame) -> HeightField:
        """Find how high things stand in a frame."""
        with self._steps.measure("heights"):
            return self._lift.heights(frame)

    def preview(self, goal: PlaceGoal) -> PreviewReply:
        """Find how a goal would end."""
        with self._steps.measure("preview"):
            return self._controller.preview(goal)

    def place(self, goal: PlaceGoal) -> GoalReply:
        """Set the robot in motion."""
        with self._steps.measure("place"):
            return self._controller.place(goal)
