"""Language model, grounding, perception and controller that do what a test tells them."""

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np

from w2c.errors import RefusedError, RemoteError, W2CError
from w2c.messages import (
    AllowedArea,
    Box,
    FitnessVerdict,
    GoalReply,
    GroundingReply,
    HeightField,
    LiftReply,
    PhraseEvidence,
    PlaceGoal,
    PreviewReply,
)
from w2c_dialogue.interfaces import Choice, Frame
from w2c_dialogue.prompts.base import Question


class ScriptedModel:
    """Answers by task; an exception is raised. The last answer of a task repeats."""

    def __init__(self, **answers: Sequence[Any]) -> None:
        self.answers = {task: list(queue) for task, queue in answers.items()}
        self.questions: list[Question] = []
        self.priors: list[dict[str, float]] = []
        self.language_model = "scripted"

    def complete(self, question: Question) -> Any:
        """Return the next answer of the task."""
        self.questions.append(question)
        return self._next(question.task)

    def choose(self, question: Question, log_prior: Mapping[str, float]) -> Choice:
        """Return the next option: a word, a word with its probability, or all probabilities."""
        self.questions.append(question)
        self.priors.append(dict(log_prior))
        answer = self._next(question.task)
        if isinstance(answer, dict):
            return Choice(max(answer, key=answer.__getitem__), answer)
        option, probability = answer if isinstance(answer, tuple) else (answer, 0.99)
        return Choice(option, {option: probability})

    def last_question(self, task: str) -> str:
        """Return what the last question of a task said."""
        return [q for q in self.questions if q.task == task][-1].messages[-1].content

    def _next(self, task: str) -> Any:
        queue = self.answers[task]
        answer = queue.pop(0) if len(queue) > 1 else queue[0]
        if isinstance(answer, W2CError):
            raise answer
        return answer


class KnownThings:
    """Grounding that knows some phrases: (left, top, right, bottom), or a list of them."""

    def __init__(self, **things: Any) -> None:
        self.things = {name.replace("_", " "): value for name, value in things.items()}
        self.error: W2CError | None = None
        self.asked: list[tuple[int, tuple[str, ...], str]] = []
        self.watched: list[tuple[int, tuple[str, ...]]] = []
        self.model = "fake"
        self.vision_model = "known things"
        self.words: set[str] = set()
        """Words that are known, beside those of the things."""

    def find(self, frame: Frame, phrases: Sequence[str]) -> GroundingReply:
        """Look for phrases that are watched for."""
        self.watched.append((frame.stamp_ns, tuple(phrases)))
        if self.error is not None:
            raise self.error
        if not phrases:
            raise RemoteError("a request needs a phrase")
        return GroundingReply(
            model=self.model,
            width=frame.width,
            height=frame.height,
            evidence=[self._evidence(phrase) for phrase in phrases],
            milliseconds=1.0,
        )

    def ground(
        self, frame: Frame, phrases: Sequence[str], want: Literal["heatmaps", "boxes"]
    ) -> list[PhraseEvidence]:
        """Return the boxes, and their centre as the point."""
        self.asked.append((frame.stamp_ns, tuple(phrases), want))
        if self.error is not None:
            raise self.error
        return [self._evidence(phrase) for phrase in phrases]

    def _evidence(self, phrase: str) -> PhraseEvidence:
        known = self.things.get(phrase.lower())
        rows = [] if known is None else known if isinstance(known, list) else [known]
        boxes = [
            Box(left=r[0], top=r[1], right=r[2], bottom=r[3], score=0.9 - 0.01 * i)
            for i, r in enumerate(rows)
        ]
        point = (0.5 * (rows[0][0] + rows[0][2]), 0.5 * (rows[0][1] + rows[0][3])) if rows else None
        return PhraseEvidence(
            phrase=phrase,
            found=bool(rows),
            score=0.9 if rows else 0.0,
            point=point,
            boxes=boxes,
            unknown_words=[] if rows else [w for w in phrase.split()[-1:] if w not in self.words],
        )


class TableTop:
    """Perception that sees a table: the picture's left is the robot's left (+y)."""

    def __init__(self) -> None:
        self.error: W2CError | None = None
        self.asked: list[tuple[float, float, int]] = []
        self.reach = 0.6
        self.verdicts = [
            FitnessVerdict(check="flat", fit=True, reason="flat", value=0.001, limit=0.004)
        ]
        self.heights_error: W2CError | None = None
        self.heights_of: list[int] = []
        self.allowed_error: W2CError | None = None
        self.cells = np.zeros((72, 128), np.uint8)
        """Of the picture: 0 = a hand may go there; 10 px each"""

    def allowed(self, frame: Frame) -> AllowedArea:
        """Return what the test says."""
        if self.allowed_error is not None:
            raise self.allowed_error
        return AllowedArea(
            stamp_ns=frame.stamp_ns,
            width=1280,
            height=720,
            cells=self.cells,
            reasons=["too steep", "no depth"],
        )

    def heights(self, frame: Frame) -> HeightField:
        """Return an empty table."""
        self.heights_of.append(frame.stamp_ns)
        if self.heights_error is not None:
            raise self.heights_error
        return HeightField(
            stamp_ns=frame.stamp_ns,
            origin=(0.4, -0.5),
            cell=0.1,
            heights=np.full((5, 10), 0.8, np.float32),
        )

    def lift(self, u: float, v: float, frame: Frame) -> LiftReply:
        """Return a point of the table."""
        self.asked.append((u, v, frame.stamp_ns))
        if self.error is not None:
            raise self.error
        return LiftReply(
            point=np.array([self.reach, (640.0 - u) / 1000.0, 0.8]),
            normal=np.array([0.0, 0.0, 1.0]),
            error_bound=0.002,
            flatness=0.001,
            slope=0.0,
            extent=0.1,
            frame_stamp_ns=frame.stamp_ns,
            verdicts=self.verdicts,
        )


class GoalTaker:
    """A controller that takes every goal, or refuses them all."""

    def __init__(self) -> None:
        self.goals: list[PlaceGoal] = []
        self.stops: list[str] = []
        self.refusal = ""
        self.previewed: list[PlaceGoal] = []
        self.outlook = PreviewReply(reachable=True, distance=0.001)
        self.preview_error: W2CError | None = None
        self.stop_error: W2CError | None = None

    def preview(self, goal: PlaceGoal) -> PreviewReply:
        """Foresee what the test says."""
        self.previewed.append(goal)
        if self.preview_error is not None:
            raise self.preview_error
        return self.outlook

    def place(self, goal: PlaceGoal) -> GoalReply:
        """Take the goal."""
        if self.refusal:
            raise RefusedError(self.refusal)
        self.goals.append(goal)
        return GoalReply(goal_id=goal.goal_id, start_tick=1)

    def stop(self, reason: str) -> str:
        """Hold."""
        if self.stop_error is not None:
            raise self.stop_error
        self.stops.append(reason)
        return "The robot holds."
