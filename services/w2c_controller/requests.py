"""Goals on their way from the threads that serve calls to the tick that begins them.

Admission reads a snapshot that the loop replaces once a tick, and appends to a deque: both are
atomic in CPython, so neither side ever waits for the other.
"""

from collections import deque
from dataclasses import dataclass

from w2c.errors import GoalRefusedError
from w2c.messages import GoalReply, PlaceGoal, ReleaseGoal
from w2c_controller.contacts import Enabled
from w2c_controller.desired import STANDING
from w2c_controller.goals import Goal, check_end_effector, check_place
from w2c_controller.parameters import EFFECTORS

FARTHEST_TICK = 30_000
"""How far ahead a goal may name its tick: a minute at 500 Hz."""


@dataclass(frozen=True)
class Situation:
    """What admission must know of the loop; replaced as a whole."""

    tick: int = 0
    ready: bool = False
    stopped: bool = False
    stale: bool = False
    holding: str = ""
    """Why the robot holds; "" = it does not"""
    busy_id: str = ""
    busy_effector: int = -1
    away: tuple[bool, bool] = (False, False)
    """Hands that lean, or are away from their rest: left, right"""
    enabled: Enabled = STANDING


@dataclass(frozen=True)
class Request:
    """A goal or a release that was admitted."""

    goal_id: str
    effector: int
    start_tick: int
    """-1: the next one"""
    goal: Goal | None
    """None: release"""


class Requests:
    """The slot between the two sides."""

    def __init__(self, hand_radius: tuple[float, float]) -> None:
        self.situation = Situation()
        self._hand_radius = hand_radius
        self._slot: deque[Request] = deque()

    def place(self, message: PlaceGoal) -> GoalReply:
        """Admit a goal. Raises GoalRefusedError."""
        goal = check_place(message, self._hand_radius)
        self._admit(message.effective_tick, goal.effector)
        return self._put(Request(goal.goal_id, goal.effector, message.effective_tick, goal))

    def release(self, message: ReleaseGoal) -> GoalReply:
        """Admit a release. Raises GoalRefusedError."""
        hand = check_end_effector(message.end_effector)
        self._admit(message.effective_tick, hand)
        if not self.situation.away[hand - 2] and message.effective_tick < 0:
            raise GoalRefusedError(
                f"the {message.end_effector.replace('_', ' ')} is at rest: nothing to release"
            )
        return self._put(Request(message.goal_id, hand, message.effective_tick, None))

    def due(self, tick: int) -> list[Request]:
        """Take the requests that begin at this tick, in order of arrival. For the loop."""
        if not self._slot:
            return []
        waiting = [self._slot.popleft() for _ in range(len(self._slot))]
        for request in waiting:
            if request.start_tick > tick:
                self._slot.append(request)
        return [request for request in waiting if request.start_tick <= tick]

    def clear(self) -> list[Request]:
        """Take all requests, due or not. For stop."""
        return [self._slot.popleft() for _ in range(len(self._slot))]

    def conflict(self, hand: int) -> str:
        """Return why a goal of this hand cannot begin now; "" = it can."""
        now = self.situation
        if now.busy_id and now.busy_effector != hand:
            return (
                f"the {EFFECTORS[now.busy_effector].replace('_', ' ')} is on its way "
                f"(goal '{now.busy_id}'); wait for it, or release it"
            )
        return ""

    def _admit(self, effective_tick: int, hand: int) -> None:
        now = self.situation
        if not now.ready:
            raise GoalRefusedError("the controller has no state of the robot yet; try again")
        if now.stale:
            raise GoalRefusedError("the robot's state is stale: nothing moves until it comes again")
        if now.stopped:
            raise GoalRefusedError("the robot is stopped; resume it first (w2c resume)")
        if now.holding:
            raise GoalRefusedError(f"the robot holds: {now.holding}")
        if 0 <= effective_tick <= now.tick:
            raise GoalRefusedError(f"tick {effective_tick} has passed, the robot is at {now.tick}")
        if effective_tick > now.tick + FARTHEST_TICK:
            raise GoalRefusedError(
                f"tick {effective_tick} is {effective_tick - now.tick} ahead, limit {FARTHEST_TICK}"
            )
        conflict = self.conflict(hand) if effective_tick < 0 else ""
        if conflict:
            raise GoalRefusedError(conflict)
        for request in tuple(self._slot):
            if request.effector != hand and effective_tick < 0 and request.start_tick < 0:
                raise GoalRefusedError(
                    f"goal '{request.goal_id}' of the other hand begins now; "
                    "one hand moves at a time"
                )

    def _put(self, request: Request) -> GoalReply:
        self._slot.append(request)
        start = request.start_tick if request.start_tick >= 0 else self.situation.tick + 1
        return GoalReply(goal_id=request.goal_id, start_tick=start)
