"""What the dialogue needs of the rest of the system. The node gives bus calls, tests give fakes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, Protocol

from w2c.bus.codec import Input
from w2c.messages import (
    AllowedArea,
    CameraView,
    GoalReply,
    HeightField,
    LiftReply,
    PhraseEvidence,
    PlaceGoal,
    PreviewReply,
)
from w2c_dialogue.prompts.base import Question


@dataclass(frozen=True)
class Frame:
    """A picture the operator may have seen."""

    stamp_ns: int
    width: int
    height: int
    jpeg: bytes
    view: CameraView | None = None
    """Where the camera was; None where perception has not said"""
    source: Input | None = None
    """The message it came in, for the record of what was computed from what"""
    robot_boot_id: str = ""
    """Of the robot that it shows; "" = not known"""


@dataclass(frozen=True)
class Choice:
    """The answer to a question with options."""

    option: str
    probabilities: dict[str, float]


class LanguageModel(Protocol):
    """Answers questions. Errors are CallErrors."""

    @property
    def language_model(self) -> str:
        """Name of the model that answered last; "" = none has."""

    def complete(self, question: Question) -> Any:
        """Return the decoded JSON; it may be anything, the reader validates."""

    def choose(self, question: Question, log_prior: Mapping[str, float]) -> Choice:
        """Return one of the question's options."""


class Grounding(Protocol):
    """Finds phrases in a picture."""

    @property
    def vision_model(self) -> str:
        """Name of the model that looked last; "" = none has."""

    def ground(
        self, frame: Frame, phrases: Sequence[str], want: Literal["heatmaps", "boxes"]
    ) -> list[PhraseEvidence]:
        """Return the evidence for each phrase, in order."""


class Lift(Protocol):
    """Knows the depth of a frame. All raise RefusedError for one of before a robot's restart."""

    def lift(self, u: float, v: float, frame: Frame) -> LiftReply:
        """Return the world point behind a pixel. Raises RefusedError where there is no depth."""

    def allowed(self, frame: Frame) -> AllowedArea:
        """Return where in a frame a hand may go. Raises CallError."""

    def heights(self, frame: Frame) -> HeightField:
        """Return how high things stand in a frame. Raises CallError."""


class Controller(Protocol):
    """Moves the robot."""

    def preview(self, goal: PlaceGoal) -> PreviewReply:
        """Return how a goal would end. Raises CallError."""

    def place(self, goal: PlaceGoal) -> GoalReply:
        """Start to move. Raises RefusedError, with a reason for the operator."""

    def stop(self, reason: str) -> str:
        """Hold the robot. Returns what acknowledged it, for the operator."""
