"""What happened in one run: every turn beside the truth about it, and how each motion ended."""

from dataclasses import dataclass, field
from typing import Literal

import msgspec

from w2c.messages import EndEffector, Task
from w2c_evaluation.scenarios.eyewitness import Wanted

Boxes = Literal["model", "truth"]
Words = Literal["model", "scripted"]
Kind = Literal["prompt", "correction", "yes", "button"]
Asks = Literal["", "answered", "open"]
Cause = Literal["words", "vision", "geometry", "control", "operator", "scene", "system"]
CAUSES: tuple[Cause, ...] = (
    "words", "vision", "geometry", "control", "operator", "scene", "system",
)  # fmt: skip

Point3 = tuple[float, float, float]


class Understood(msgspec.Struct, frozen=True, kw_only=True):
    """One turn of the conversation, and what was true in its picture."""

    text: str
    kind: Kind
    module: str
    ok: bool
    reply: str
    seconds: float
    asks: Asks = ""
    """The reply is a question that the operator could answer, or that none of its options fitted"""
    asked: bool = True
    """A model was asked what was meant; False: it was answered, or refused, before"""
    answers: bool = False
    """It answers a question: `kind` is that of the words that were asked about"""
    pixel: tuple[float, float] | None = None
    """Shown after it"""
    before: tuple[float, float] | None = None
    """Shown before it"""
    meant: tuple[float, float] | None = None
    """The move that the words of a correction ask for (du, dv) [px]"""
    phrases: tuple[str, ...] = ()
    boxes: tuple[tuple[float, float, float, float], ...] = ()
    """Left, top, right, bottom of each phrase's [px]"""
    true_boxes: tuple[tuple[float, float, float, float] | None, ...] = ()
    """Of the things that these phrases mean; None = not to be seen, or nobody would say so"""
    point: Point3 | None = None
    """Of the target, as perception found it, in the world [m]"""
    true_point: Point3 | None = None
    """What is behind the shown pixel [m]"""
    true_owner: str = ""
    """Whose surface that is"""
    effector: str = ""
    task: str = ""
    goal_id: str = ""


@dataclass
class Motion:
    """What a confirmed target led to."""

    goal_id: str
    effector: EndEffector
    task: Task
    confirmed_ns: int
    """Robot time"""
    state: str = ""
    """loaded, reached, or how else it ended"""
    reason: str = ""
    ended_ns: int = -1
    settled_ns: int = -1


@dataclass
class PromptRun:
    """One prompt, from its words to the end of its motion."""

    turns: list[Understood] = field(default_factory=list)
    wanted: Wanted | None = None
    """None where the place is not to be seen"""
    motion: Motion | None = None
    problem: str = ""
    """Why it ended without a motion"""

    @property
    def corrections(self) -> int:
        """Return how many were said."""
        return sum(turn.kind == "correction" and not turn.answers for turn in self.turns)


@dataclass
class Played:
    """One run, as far as it came."""

    prompts: list[PromptRun] = field(default_factory=list)
    goal_ids: list[str] = field(default_factory=list)
    """Of all goals that the controller accepted, whoever asked for them"""
    afterwards_problem: str = ""
    """What went wrong in what was done after the words"""
    system_problem: str = ""
    """A process that did not start or answer"""


class RunResult(msgspec.Struct, frozen=True, kw_only=True):
    """One run, judged: a line of the file of results."""

    scenario: str
    seed: int
    succeeded: bool
    fell: bool
    unconfirmed_motions: int
    problems: tuple[str, ...] = ()
    cause: str = ""
    """One of CAUSES; empty for a success"""
    corrections: tuple[int, ...] = ()
    """Of each prompt"""
    place_errors_mm: tuple[float, ...] = ()
    """Between each confirmed target and the wanted place, in the world; NaN is left out"""
    hand_errors_mm: tuple[float, ...] = ()
    support_force_n: tuple[float, ...] = ()
    """5th percentile, median, and 95th while the other hand reached"""
    turns: tuple[tuple[Understood, ...], ...] = ()
    wrong_turns: dict[str, int] = {}
    """Cause -> turns that were answered wrongly from it, also those that were made good"""
    recording: str = ""
    """Kept for failures; in the study's directory"""
    images: str = ""
    """Directory of this run's pictures, in the study's"""
    seconds: float = 0.0
    """It took, on the wall"""
