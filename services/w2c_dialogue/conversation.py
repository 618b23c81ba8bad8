"""What has been said and shown: the target, its history, the goal that is under way.

States: nothing shown -> proposed -> confirmed (the robot moves) -> reached | in contact |
abandoned -> nothing shown. A new prediction replaces the old target; each change of the point
gives the target a new id, so that a confirmation always names the point that was seen.

While the robot moves, a second target may be proposed: a correction of the one it moves to, or
another place. The motion goes on to the confirmed target until the proposed one is confirmed.
"""

from dataclasses import dataclass, field, replace

import msgspec

from w2c.errors import RefusedError
from w2c.messages import (
    ConversationState,
    EndEffector,
    GoalEvent,
    LiftReply,
    Target,
    Task,
)
from w2c_dialogue.frames import DEFAULT_PIXELS_PER_CM
from w2c_dialogue.interfaces import Frame
from w2c_dialogue.prompts.base import CorrectionScene, Move
from w2c_dialogue.rest import LastMotion, Rest
from w2c_dialogue.sight import Prediction

MAX_MOVES = 50
"""Corrections that are remembered; nobody refers further back."""


@dataclass(frozen=True)
class Shown:
    """The target on the screen."""

    target: Target
    frame: Frame
    start: tuple[float, float]
    moves: tuple[Move, ...] = ()
    instructions: tuple[str, ...] = ()
    effector: EndEffector | None = None
    """Fixed by pointing; None: the instruction decides"""
    task: Task | None = None
    named: str = ""
    """The thing that the operator's words put the target on; "" = a place beside things, or a
    click"""
    lifted: LiftReply | None = None
    """What perception knows of the surface there; None without depth"""
    pixels_per_cm: float = DEFAULT_PIXELS_PER_CM
    """Where it was before the last correction: for corrections from a place without depth"""

    def scene(self, at: tuple[float, float], pixels_per_cm: float) -> CorrectionScene:
        """Return what a correction may refer to, with the target at this pixel now."""
        du, dv = at[0] - self.target.u, at[1] - self.target.v
        return CorrectionScene(
            target=at,
            start=(self.start[0] + du, self.start[1] + dv),
            moves=self.moves,
            instructions=self.instructions,
            objects=(),
            pixels_per_cm=pixels_per_cm,
        )


@dataclass(frozen=True)
class Goal:
    """A confirmed target the robot is moving to."""

    goal_id: str
    target: Target
    effector: EndEffector
    task: Task
    since_ns: int
    """Clock time of the last sign of life [ns]"""
    shown: Shown
    """What was confirmed, with its history: a correction meanwhile starts from it"""
    touching: bool = False
    """The end effector has met the surface: to go elsewhere it lifts off first"""

    def base(self) -> Shown:
        """Return what a correction changes: the same limb goes on, for the same task."""
        return replace(self.shown, effector=self.effector, task=self.task)


@dataclass
class Conversation:
    """The state of one conversation. `prefix` tells the ids of one process from the next's."""

    prefix: str
    shown: Shown | None = None
    goal: Goal | None = None
    last: LastMotion = field(default_factory=LastMotion)
    _count: int = field(default=0)

    @property
    def state(self) -> ConversationState:
        """What the conversation is at: a motion before a target, both before what was."""
        if self.goal is not None:
            return "moving"
        return "target_shown" if self.shown is not None else self.last.rest

    def base(self) -> Shown | None:
        """Return what a correction speaks of: the shown target, else the one that is moved to."""
        if self.shown is not None or self.goal is None:
            return self.shown
        return self.goal.base()

    def propose(
        self,
        prediction: Prediction,
        frame: Frame,
        *,
        instruction: str,
        lifted: LiftReply | None,
        warnings: tuple[str, ...] = (),
        effector: EndEffector | None = None,
        task: Task | None = None,
        named: str = "",
    ) -> Target:
        """Show a new target instead of the old one."""
        target = self._target(
            prediction,
            frame,
            instruction=instruction,
            lifted=lifted,
            warnings=warnings,
            corrections=0,
        )
        self.shown = Shown(
            target,
            frame,
            (prediction.u, prediction.v),
            effector=effector,
            task=task,
            named=named,
            lifted=lifted,
        )
        return target

    def correct(
        self,
        base: Shown,
        prediction: Prediction,
        scene: CorrectionScene,
        frame: Frame,
        *,
        said: str,
        lifted: LiftReply | None,
        warnings: tuple[str, ...] = (),
        undo: bool = False,
    ) -> Target:
        """Show the target of `base`, which is at `scene.target`, elsewhere, and remember how.

        An undo forgets a move.
        """
        target = self._target(
            prediction,
            frame,
            instruction=base.target.instruction,
            lifted=lifted,
            warnings=warnings,
            corrections=base.target.corrections + 1,
        )
        moves, instructions = base.moves[:-1], base.instructions[:-1]
        if not undo:
            move = Move(prediction.u - scene.target[0], prediction.v - scene.target[1])
            moves = (*base.moves, move)[-MAX_MOVES:]
            instructions = (*base.instructions, said)[-MAX_MOVES:]
        self.shown = replace(
            base,
            target=target,
            frame=frame,
            start=scene.start,
            moves=moves,
            instructions=instructions,
            lifted=lifted,
            pixels_per_cm=scene.pixels_per_cm,
        )
        return target

    def require_shown(self) -> Shown:
        """Return what is shown. Raises RefusedError where nothing is."""
        if self.shown is None and self.goal is not None:
            limb = self.goal.effector.replace("_", " ")
            raise RefusedError(
                f"I am moving my {limb} to the target you confirmed already. Correct it, for "
                "example: a bit to the left; or say stop."
            )
        if self.shown is None:
            raise RefusedError(
                "There is no target yet. Tell me where to put a hand, for example: lean on the "
                "table."
            )
        return self.shown

    def check_confirmation(self, target_id: str) -> Shown:
        """Return the shown target if this id names it. Raises RefusedError, with what to do."""
        shown = self.require_shown()
        if not target_id:
            raise RefusedError(
                "I do not know which target you saw. Press Confirm on the page, or give its id: "
                f"`w2c confirm {shown.target.target_id}`."
            )
        if target_id != shown.target.target_id:
            raise RefusedError(
                f"Target {target_id} is no longer the one on the screen ({shown.target.target_id} "
                "is). "
                "Look at the picture and confirm again."
            )
        return shown

    def next_id(self, kind: str) -> str:
        """Return an id that no target or goal had before."""
        self._count += 1
        return f"{kind}-{self.prefix}-{self._count}"

    def lifted(self, lifted: LiftReply) -> Shown:
        """Give the shown target the depth it did not have."""
        shown = self.require_shown()
        target = msgspec.structs.replace(
            shown.target, point=lifted.point, normal=lifted.normal, warning=lifted.warning
        )
        self.shown = replace(shown, target=target, lifted=lifted)
        return self.shown

    def confirm(self, goal_id: str, effector: EndEffector, task: Task, now_ns: int) -> Target:
        """The controller took the shown target, instead of any that it moved to before."""
        shown = self.require_shown()
        target = msgspec.structs.replace(shown.target, state="confirmed")
        self.goal = Goal(goal_id, target, effector, task, now_ns, shown)
        self.shown = None
        return target

    def progress(self, event: GoalEvent, now_ns: int) -> tuple[Goal, Target] | None:
        """Follow the goal. Returns it with its target when it is over, else None."""
        self.last.follow(event)
        goal = self.goal
        if goal is None or event.goal_id != goal.goal_id:
            return None
        if event.state in ("unreachable", "aborted", "released"):
            return goal, self.abandon_goal(event.reason)
        if event.state == "loaded" or (event.state == "reached" and goal.task == "reach"):
            self.goal = None
            state: Rest = "in_contact" if event.state == "loaded" else "reached"
            self.last.end(goal.goal_id, state)
            return goal, msgspec.structs.replace(goal.target, state=state)
        touching = goal.touching or event.state == "touched"
        self.goal = replace(goal, since_ns=now_ns, touching=touching)
        return None

    def abandon_shown(self, reason: str) -> Target:
        """Give up the target on the screen. Raises RefusedError where there is none."""
        target = msgspec.structs.replace(
            self.require_shown().target, state="abandoned", warning=reason
        )
        self.shown = None
        return target

    def abandon_goal(self, reason: str) -> Target:
        """Give up the goal that is under way."""
        if self.goal is None:
            raise RefusedError("The robot is not moving to a target.")
        target = msgspec.structs.replace(self.goal.target, state="abandoned", warning=reason)
        self.last.end(self.goal.goal_id, "idle")
        self.goal = None
        return target

    def _target(
        self,
        prediction: Prediction,
        frame: Frame,
        *,
        instruction: str,
        lifted: LiftReply | None,
        warnings: tuple[str, ...],
        corrections: int,
    ) -> Target:
        every = (
            *prediction.warnings,
            *warnings,
            *((lifted.warning,) if lifted and lifted.warning else ()),
        )
        return Target(
            target_id=self.next_id("target"),
            frame_stamp_ns=frame.stamp_ns,
            u=prediction.u,
            v=prediction.v,
            point=lifted.point if lifted else None,
            normal=lifted.normal if lifted else None,
            state="proposed",
            corrections=corrections,
            instruction=instruction,
            boxes=[item.box for item in prediction.objects],
            phrases=[item.phrase for item in prediction.objects],
            warning=" ".join(every),
        )
