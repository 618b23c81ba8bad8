"""Goals on their way from the threads that serve calls to the tick that begins them.

Admission reads a snapshot that the loop replaces once a tick, and appends to a deque: both are
atomic in CPython, so the loop never waits. Threads that ask wait for each other.
"""

import threading
from collections import deque
from dataclasses import dataclass

import msgspec
import numpy as np
import numpy.typing as npt

from w2c.errors import GoalRefusedError
from w2c.messages import GoalReply, HeightField, PlaceGoal, ReleaseGoal
from w2c_controller.goals.body import Body
from w2c_controller.goals.goals import NOMINAL, Goal, check_end_effector, check_place
from w2c_controller.goals.planner import RoutePlanner
from w2c_controller.parameters import FEET, HANDS, Limits
from w2c_controller.seiko.contacts import Enabled
from w2c_controller.seiko.desired import STANDING
from w2c_controller.switching.blocking import spoken

Vector = npt.NDArray[np.float64]

FARTHEST_TICK = 30_000
"""How far ahead a goal may name its tick: a minute at 500 Hz."""
REMEMBERED = 1000
"""Ids of goals that were taken: the same goal again is a replay, not another wish."""


class Situation(msgspec.Struct, frozen=True):
    """What admission must know of the loop; replaced as a whole, at each tick."""

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
    desired: tuple[int, Vector] | None = None
    """A tick, and the desired posture (nq,) at its end; None before the first"""


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

    def __init__(
        self,
        hand_radius: tuple[float, float],
        limits: Limits = NOMINAL,
        body: Body | None = None,
        planner: RoutePlanner | None = None,
    ) -> None:
        """Begin without requests.

        Args:
            hand_radius: Of the hands, left and right [m].
            limits: Of forces.
            body: Where goals cannot be; None: not looked at.
            planner: Of ways around what a goal says stands there; None: not looked at.
        """
        self.situation = Situation()
        self._hand_radius = hand_radius
        self._limits = limits
        self._body = body
        self._planner = planner
        self._slot: deque[Request] = deque()
        self._taken: deque[str] = deque(maxlen=REMEMBERED)
        self._asking = threading.Lock()
        """Among the threads that ask; the loop never takes it"""

    def place(self, message: PlaceGoal) -> GoalReply:
        """Admit a goal. Raises GoalRefusedError."""
        goal = check_place(message, self._hand_radius, self._limits)
        with self._asking:
            self._admit(goal.goal_id, message.effective_tick, goal.effector)
            self._check_support(goal.effector)
            tick, goal = self.judge(goal, message.obstacles)
            request = Request(goal.goal_id, goal.effector, message.effective_tick, goal)
            return self.put(request, posture_tick=tick)

    def release(self, message: ReleaseGoal) -> GoalReply:
        """Admit a release. Raises GoalRefusedError."""
        effector = check_end_effector(message.end_effector)
        with self._asking:
            self._admit(message.goal_id, message.effective_tick, effector)
            self._check_support(effector)
            if message.effective_tick < 0 and not self._away(effector):
                where = "in the air" if effector in FEET else "at rest"
                raise GoalRefusedError(
                    f"the {spoken(effector)} is {where} already: nothing to release"
                )
            return self.put(Request(message.goal_id, effector, message.effective_tick, None))

    def judge(self, goal: Goal, field: HeightField | None) -> tuple[int, Goal]:
        """Return the goal with what its way must clear, and the tick whose posture decided.

        Args:
            goal: That was checked.
            field: What stands there; None: nothing is known of it.

        Raises:
            GoalRefusedError: the robot itself is there, or the way is blocked.
        """
        # One for all of it: the loop goes on meanwhile, and a replay must find the same.
        now = self.situation
        if now.desired is None:
            return -1, goal
        tick, posture = now.desired
        self._check_body(goal, posture)
        if field is None or self._planner is None:
            return tick, goal
        leaves = now.enabled[goal.effector]
        return tick, self._planner.plan(goal, field, posture, leaves=leaves)

    def put(self, request: Request, *, posture_tick: int = -1) -> GoalReply:
        """Take what was admitted, judged by the posture of a tick."""
        self._slot.append(request)
        self._taken.append(request.goal_id)
        start = request.start_tick if request.start_tick >= 0 else self.situation.tick + 1
        return GoalReply(goal_id=request.goal_id, start_tick=start, posture_tick=posture_tick)

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

    def conflict(self, effector: int) -> str:
        """Return why a goal of this end effector cannot begin now; "" = it can."""
        now = self.situation
        if now.busy_id and now.busy_effector != effector:
            return (
                f"the {spoken(now.busy_effector)} is on its way "
                f"(goal '{now.busy_id}'); wait for it, or release it"
            )
        return self.last_support(effector)

    def last_support(self, effector: int) -> str:
        """Return why an end effector must stay in contact whatever the posture; "" = it need not.

        Hands alone cannot carry the robot: without a foot there is no equilibrium.
        """
        enabled = self.situation.enabled
        others = [k for k in FEET if enabled[k] and k != effector]
        if effector in HANDS or not enabled[effector] or others:
            return ""
        leaning = [spoken(k) for k in HANDS if enabled[k]]
        most = self._limits.hand_force_max
        hands = (
            f"the {' and the '.join(leaning)} at most {most:.0f} N each" if leaning else "no one"
        )
        return (
            f"the {spoken(effector)} is the only foot on the ground, and without it {hands} would "
            "carry the robot; put the other foot down first"
        )

    def _away(self, effector: int) -> bool:
        """Return whether there is something to release."""
        if effector in FEET:
            return self.situation.enabled[effector]
        return self.situation.away[effector - HANDS[0]]

    def _check_support(self, effector: int) -> None:
        reason = self.last_support(effector)
        if reason:
            raise GoalRefusedError(reason)

    def _check_body(self, goal: Goal, posture: Vector) -> None:
        """Refuse points where the robot itself is."""
        if self._body is None:
            return
        self._body.place(posture)
        found = self._body.inside(goal.point, goal.effector)
        if found is not None:
            capsule, depth = found
            raise GoalRefusedError(
                f"the point is inside the robot: {100 * depth:.0f} cm within the {capsule.part} "
                f"(radius {100 * capsule.radius:.0f} cm); choose a point beside it"
            )

    def _admit(self, goal_id: str, effective_tick: int, effector: int) -> None:
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
        if goal_id in self._taken:
            raise GoalRefusedError(
                f"goal '{goal_id}' was taken already: a goal that comes again does not move the "
                "robot again; give a new one another id"
            )
        conflict = self.conflict(effector) if effective_tick < 0 else ""
        if conflict:
            raise GoalRefusedError(conflict)
        for request in tuple(self._slot):
            if request.effector != effector and effective_tick < 0 and request.start_tick < 0:
                raise GoalRefusedError(
                    f"goal '{request.goal_id}' of the {spoken(request.effector)} begins now; "
                    "one end effector moves at a time"
                )
