"""Messages between operator and dialogue."""

from typing import Annotated, Literal

import msgspec

from w2c.messages.base import Array, Message, Name, RobotBoot, Stamp, Text, check_array
from w2c.messages.control import EndEffector, Task
from w2c.messages.models import Box

ConversationState = Literal["idle", "target_shown", "moving", "in_contact", "reached"]


class Target(Message, frozen=True, kw_only=True):
    """The point the system understood. Only meaningful with the frame it was chosen in."""

    target_id: Name
    frame_stamp_ns: Stamp
    u: float
    v: float
    """Pixel in that frame"""
    point: Array | None
    """(3,) in the world [m]; None without depth"""
    normal: Array | None
    """(3,)"""
    state: Literal["proposed", "confirmed", "reached", "in_contact", "abandoned"]
    corrections: int = 0
    instruction: Text = ""
    """The words that asked for it"""
    boxes: list[Box] = []
    """What was found for the objects in the words, in order of mention"""
    phrases: list[str] = []
    warning: Text = ""

    def __post_init__(self) -> None:
        """Refuse arrays of the wrong shape."""
        if self.point is not None:
            check_array("point", self.point, (3,))
        if self.normal is not None:
            check_array("normal", self.normal, (3,))


class SayRequest(Message, frozen=True, kw_only=True):
    """What the operator said, and the frame that was on the screen meanwhile."""

    text: Annotated[str, msgspec.Meta(min_length=1, max_length=500)]
    frame_stamp_ns: int = -1
    """-1: the operator saw no picture; the newest frame is meant"""
    robot_boot_id: RobotBoot = ""
    """Of the robot when it took that frame. "" = not checked"""
    target_id: str = ""
    """The target on the screen, so that a spoken "yes" confirms what was seen; empty: none"""


class ConfirmRequest(Message, frozen=True, kw_only=True):
    """Go there. A target that is no longer the current one is refused."""

    target_id: Name


class PointRequest(Message, frozen=True, kw_only=True):
    """The operator points instead of speaking."""

    u: float
    v: float
    frame_stamp_ns: int = -1
    robot_boot_id: RobotBoot = ""
    """As in `SayRequest`"""
    end_effector: EndEffector | None = None
    task: Task | None = None


class ModelAnswer(Message, frozen=True, kw_only=True):
    """What the language model answered to one question of a turn."""

    task: Name
    """select, analyze, objects, relative, correct or effector"""
    answer: Text
    """The JSON value, expressions as the model wrote them; of `select`, the option"""
    probabilities: dict[str, float] = {}
    """Of the options; of `select` only"""
    model: str = ""


class Sighting(Message, frozen=True, kw_only=True):
    """What the vision model found of one phrase, without the heatmap."""

    phrase: Name
    found: bool
    score: float
    boxes: list[Box] = []
    """Best first; the chosen one is among the target's"""
    unknown_words: list[str] = []


class Evidence(Message, frozen=True, kw_only=True):
    """What a turn was made from. After a question, what was found before it, too."""

    prompts: Name
    """Prompt set"""
    answers: list[ModelAnswer] = []
    """In the order in which they were asked for"""
    sightings: list[Sighting] = []
    """In order of mention"""
    vision_model: str = ""
    corrected_from: tuple[float, float] | None = None
    """Where the target was before a correction, in the picture of the turn (u, v) [px]"""


class Turn(Message, frozen=True, kw_only=True):
    """One exchange: what was said, what was understood, what was answered."""

    stamp_ns: Stamp
    text: Text
    module: Name
    """prediction.absolute, prediction.relative, correction, confirmation, point, cancel, question
    or none"""
    reply: Text
    """To the operator"""
    ok: bool
    """False: nothing changed; the reply says why and what to do, or asks"""
    retryable: bool = False
    """Where not ok: the same, said again a little later, may be (a service was late)"""
    options: list[str] = []
    """What may be answered where the reply is a question"""
    target: Target | None = None
    state: ConversationState = "idle"
    """After the turn. While the robot moves, a target may be shown besides"""
    goal_id: str = ""
    end_effector: str = ""
    task: str = ""
    seconds: float
    """From the utterance to the answer [s]"""
    steps: dict[str, float] = {}
    """Where the time went [s]: selector, analyzer, grounding, relative, correction, lift ..."""
    evidence: Evidence | None = None
    """None where no model was asked"""
