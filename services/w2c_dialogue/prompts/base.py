"""A question to a model, and what every prompt set offers.

A prompt set turns an utterance and what is known of the scene into questions. The answers of all
sets have the same fields and are read by the modules; a set may ask for more (a chain of thought)
before them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, Protocol

from w2c.messages import Box, ChatMessage
from w2c_dialogue.utterance import Mention, Utterance

TaskName = Literal["select", "analyze", "objects", "relative", "correct", "effector"]
MODULES = ("prediction", "correction", "confirmation")
POSITIONS = ("absolute", "relative")
EFFECTORS = ("left_hand", "right_hand", "left_foot", "right_foot", "unspecified")
TASKS = ("contact", "reach")


@dataclass(frozen=True)
class Question:
    """One request to a language model: complete to JSON of `schema`, or choose of `options`."""

    task: TaskName
    messages: tuple[ChatMessage, ...]
    constant_messages: int
    """How many leading messages are the same in every question of this task."""
    schema: dict[str, Any] | None = None
    options: tuple[str, ...] = ()


@dataclass(frozen=True)
class SceneObject:
    """Something the operator spoke of, found in the picture."""

    phrase: str
    box: Box


@dataclass(frozen=True)
class Move:
    """One step of the target in the picture [px]: du to the right, dv down."""

    du: float
    dv: float


@dataclass(frozen=True)
class CorrectionScene:
    """What a correction may refer to."""

    target: tuple[float, float]
    """(u, v) [px]"""
    start: tuple[float, float]
    """Where the target was before the first correction [px]"""
    moves: tuple[Move, ...]
    """Corrections so far, oldest first"""
    instructions: tuple[str, ...]
    """The words of those corrections"""
    objects: tuple[SceneObject, ...]
    """In order of mention"""
    pixels_per_cm: float


class PromptSet(Protocol):
    """The questions of one kind of model."""

    @property
    def name(self) -> str:
        """Name in the configuration."""

    def select(self, utterance: Utterance) -> Question:
        """Ask which module an utterance is for; options are `MODULES`."""

    def analyze(self, utterance: Utterance) -> Question:
        """Ask for `position` and `objects` of an instruction."""

    def objects(self, utterance: Utterance) -> Question:
        """Ask for the `objects` of a correction."""

    def read_mention(self, value: str, utterance: Utterance) -> Mention:
        """Return what an entry of `objects` names. Raises ModelError."""

    def relative(
        self,
        utterance: Utterance,
        mentions: Sequence[Mention],
        objects: Sequence[SceneObject],
        pixels_per_cm: float,
    ) -> Question:
        """Ask for the expressions `x` and `y` of a point that is described relative to objects."""

    def correct(
        self, utterance: Utterance, mentions: Sequence[Mention], scene: CorrectionScene
    ) -> Question:
        """Ask for the expressions `x` and `y` of the corrected target."""

    def parts(self, utterance: Utterance) -> tuple[Utterance, ...]:
        """Return the parts of a correction that are asked one by one, and add up; one: as it is."""

    def effector(self, utterance: Utterance) -> Question:
        """Ask for `effector` and `task`."""


def schema_of(properties: dict[str, Any]) -> dict[str, Any]:
    """Return the JSON schema of an object that has exactly these properties, in this order."""
    return {
        "type": "object",
        "properties": properties,
        "required": list(properties),
        "additionalProperties": False,
    }
