"""A dialogue among fakes, and how tests talk to it."""

from collections.abc import Sequence

import numpy as np

from fakes.dialogue_world import GoalTaker, KnownThings, ScriptedModel, TableTop
from w2c.clock import StepClock
from w2c.messages import AllowedArea, CameraView, GoalEvent, SayRequest, Turn
from w2c_dialogue.advice.guard import Guard
from w2c_dialogue.advice.pointing import MaskedPointing
from w2c_dialogue.advice.veto import UncheckedVeto
from w2c_dialogue.advice.watch import Watch
from w2c_dialogue.advice.wordlist import VETOED
from w2c_dialogue.frames import FrameStore
from w2c_dialogue.interfaces import Frame
from w2c_dialogue.limbs import Limbs
from w2c_dialogue.pipeline import Dialogue
from w2c_dialogue.prompts.embedded import EmbeddedPrompts

BOOK = (400, 300, 600, 420)
CUP = (900, 200, 960, 280)
STAY = {"x": "target.u", "y": "target.v"}


class World:
    """A dialogue among fakes."""

    unchecked: UncheckedVeto = "refuse"

    def __init__(self, **answers: Sequence[object]) -> None:
        defaults: dict[str, Sequence[object]] = {
            "select": ["prediction"],
            "analyze": [{"position": "absolute", "objects": ["8-8"]}],
            "objects": [{"objects": []}],
            "effector": [{"effector": "right_hand", "task": "contact"}],
        }
        self.model = ScriptedModel(**{**defaults, **answers})
        self.grounding = KnownThings(book=BOOK, cup=CUP)
        self.lift = TableTop()
        self.controller = GoalTaker()
        self.frames = FrameStore()
        self.clock = StepClock(1)
        self.add_frame(100)
        self.watch = Watch(self.grounding.find, (*VETOED, "glass"), patience_s=1.0)
        self.guard = Guard(self.watch, VETOED, share=0.3, margin=0.05, unchecked=self.unchecked)
        self.limbs = Limbs(EmbeddedPrompts())
        self.areas: list[AllowedArea] = []
        self.dialogue = Dialogue(
            self.model,
            self.grounding,
            self.lift,
            self.controller,
            prompts=EmbeddedPrompts(),
            frames=self.frames,
            guard=self.guard,
            limbs=self.limbs,
            masked=self.masked_pointing(),
            clock=self.clock,
            prefix="t",
        )
        self.shown = ""

    def masked_pointing(self) -> MaskedPointing | None:
        return None

    def add_frame(self, stamp_ns: int) -> None:
        self.frames.add_frame(Frame(stamp_ns, 1280, 720, b"jpeg"))

    def add_view(self, stamp_ns: int, x: float = 0.0) -> None:
        world_from_camera = np.eye(4)
        world_from_camera[0, 3] = x
        self.frames.add_view(
            CameraView(
                stamp_ns=stamp_ns,
                world_from_camera=world_from_camera,
                intrinsics=(800.0, 800.0, 640.0, 360.0),
                width=1280,
                height=720,
            )
        )

    def say(self, text: str, stamp_ns: int = -1, target_id: str | None = None) -> Turn:
        seen = self.shown if target_id is None else target_id
        turn = self.dialogue.say(SayRequest(text=text, frame_stamp_ns=stamp_ns, target_id=seen))
        if turn.target is not None:
            self.shown = turn.target.target_id if turn.target.state == "proposed" else ""
        return turn

    def event(
        self, goal_id: str, state: str, task: str = "contact", reason: str = ""
    ) -> Turn | None:
        return self.dialogue.follow(
            GoalEvent(
                stamp_ns=1,
                goal_id=goal_id,
                end_effector="right_hand",
                task=task,  # type: ignore[arg-type]
                state=state,  # type: ignore[arg-type]
                reason=reason,
            )
        )


FIRST = "Place your right hand on top of the book"


def first_words(text: str = FIRST) -> dict[str, Sequence[object]]:
    return {
        "analyze": [
            {"position": "absolute", "objects": [f"{len(text.split())}-{len(text.split())}"]}
        ]
    }
