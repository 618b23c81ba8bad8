"""The states of a goal: approach, touch, load, contact; unload, retreat; reach.

    contact:  hold -> approach -> touch -> load -> contact        a hand that leans stays a support
    reach:    hold -> approach -> reach                           as close as balance allows
    release:  contact -> unload -> retreat -> hold,   reach -> retreat -> hold

A contact is enabled only by a measured touch, never in the air. Every phase that waits has a limit,
and says why it gave up.
"""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from w2c.geometry import frame_from_normal
from w2c_controller.bookkeeping import Bookkeeping
from w2c_controller.events import Event, GoalPhase, short_by
from w2c_controller.goals import Goal
from w2c_controller.grasp import pointing_rotation
from w2c_controller.hands import Hands
from w2c_controller.parameters import HANDS, Motion
from w2c_controller.retargeting import Retargeting
from w2c_controller.routes import approach, at, retreat, way_back
from w2c_controller.sensing import Feeler, Measured
from w2c_controller.stall import StallDetector
from w2c_controller.trajectory import Path

Vector = npt.NDArray[np.float64]

SETTLE_TIME = 0.3
"""Rest above the surface, where the force estimate is tared [s]."""
SETTLE_DISTANCE = 0.015
CONFIRM_TIME = 0.2
"""How long a load must be measured [s]."""


class Switching(Bookkeeping):
    """One goal at a time; hands that lean, or hold a reached point, stay as they are meanwhile."""

    def __init__(self, retargeting: Retargeting, hands: Hands) -> None:
        super().__init__()
        self._retargeting = retargeting
        self._hands = hands
        self._motion: Motion = retargeting.parameters.motion
        self._lead = retargeting.parameters.filters.lead_position
        self._dt = retargeting.dt
        self._feelers = {k: Feeler() for k in HANDS}
        self._away = {k: np.array([0.0, 0.0, 1.0]) for k in HANDS}
        """Back the way each hand came: along the normal of a contact, against reaching fingers"""
        self._path = at(hands.position(HANDS[0]))
        self._next: Goal | None = None
        self._elapsed = 0.0
        self._settled = 0.0
        self._bump = False
        """Whether a reaching hand touched something on its way"""
        self._stall = StallDetector(self._motion, self._dt)
        self._steps: dict[GoalPhase, Callable[[Measured], None]] = {
            "approach": self._approach,
            "touch": self._touch,
            "load": self._load,
            "reach": self._reach,
            "unload": self._unload,
            "retreat": self._retreat,
        }

    def place(self, goal: Goal) -> None:
        """Begin a goal; its hand leaves its support first where it has one."""
        self._supersede(goal.goal_id)
        if self._retargeting.state.enabled[goal.effector]:
            self.goal, self._next = goal, goal
            self._begin_unload(goal.effector)
        else:
            self._begin_approach(goal)

    def release(self, goal_id: str, hand: int) -> None:
        """Take a hand off, and bring it back to where it was at the start."""
        self._supersede(goal_id)
        self.goal, self._next, self.releasing_id = None, None, goal_id
        if self._retargeting.state.enabled[hand]:
            self._begin_unload(hand)
        else:
            self._begin_retreat(hand)

    def abort(self, reason: str) -> None:
        """End the goal under way; hands stay where they are. For stop."""
        if self._unfinished():
            self._emit("aborted", reason)
        for k in HANDS:
            self._retargeting.keep(k)
            self._hands.stop(k)
        self.goal, self._next, self.releasing_id = None, None, ""
        self._enter("hold")

    def step(self, measured: Measured) -> list[Event]:
        """Advance by one tick; returns what changed."""
        self._elapsed += self._dt
        action = self._steps.get(self.phase)
        if action is not None:
            action(measured)
        return self._log.take()

    def distance(self) -> float:
        """Return what is left between hand and target [m]; -1 without a goal."""
        if self.goal is None:
            return -1.0
        return float(np.linalg.norm(self._hands.position(self.goal.effector) - self.goal.target))

    def normal_load(self, hand: int, measured: Measured) -> float:
        """Return the measured normal force on a hand [N], without what it read in the air."""
        return self._feelers[hand].normal_force(measured.hands[hand - HANDS[0]])

    # --- beginnings ------------------------------------------------------------------------------
    def _begin_approach(self, goal: Goal) -> None:
        self.goal, self._effector, self.releasing_id = goal, goal.effector, ""
        self._next = None
        self._feelers[goal.effector] = Feeler(goal.normal)
        self._log.begin()
        self._bump = False
        self._away[goal.effector] = way_back(goal)
        if goal.task == "reach":
            self._hands.rotations[goal.effector] = pointing_rotation(-self._away[goal.effector])
        else:
            self._hands.relax(goal.effector)
        start = self._hands.position(goal.effector)
        self._travel("approach", approach(goal, start, self._motion))
        self._emit("moving")

    def _begin_unload(self, hand: int) -> None:
        self._effector = hand
        self._retargeting.release(hand)
        self._enter("unload")

    def _begin_retreat(self, hand: int) -> None:
        self._effector = hand
        self._hands.relax(hand)
        start, rest = self._hands.position(hand), self._hands.rest[hand]
        self._travel("retreat", retreat(start, self._away[hand], rest, self._motion))

    def _travel(self, phase: GoalPhase, path: Path) -> None:
        self._path = path
        self._hands.targets[self._effector] = self._path.position()
        self._enter(phase)

    def _enter(self, phase: GoalPhase) -> None:
        self.phase = phase
        self._elapsed = 0.0
        self._settled = 0.0
        self._stall.reset()

    # --- phases ----------------------------------------------------------------------------------
    def _follow(self) -> bool:
        """Advance the path while the hand keeps up. Returns whether the hand is stuck."""
        path, hand = self._path, self._effector
        position = self._hands.position(hand)
        if float(np.linalg.norm(path.position() - position)) < self._lead:
            path.advance(self._dt)
            self._stall.reset()
        self._hands.targets[hand] = path.position()
        return self._stall.step(position)

    def _approach(self, measured: Measured) -> None:
        goal, path = self._require_goal(), self._path
        stuck = self._follow()
        if goal.task == "reach":
            if stuck:
                # The way over the surface is out of reach; the point itself may not be.
                path.next_leg()
                self._stall.reset()
            if path.leg == 0:
                self._feelers[self._effector].tare(measured.hands[self._effector - HANDS[0]])
            elif self._bumped(measured):
                self._enter("reach")
            elif path.finished or stuck:
                self._hands.targets[self._effector] = path.end
                self._enter("reach")
            return
        if path.leg > 0:
            self._hands.targets[self._effector] = path.legs[0].position(path.legs[0].duration)
            self._enter("touch")
        elif stuck or self._elapsed > self._motion.approach_timeout:
            self._give_up(unreachable=True)

    def _touch(self, measured: Measured) -> None:
        """Rest above the surface and tare, then go down until the surface stops the hand."""
        path, hand = self._path, self._effector
        above = path.legs[1].points[0]
        if self._settled < SETTLE_TIME:
            near = float(np.linalg.norm(self._hands.position(hand) - above)) < SETTLE_DISTANCE
            self._settled = self._settled + self._dt if near else 0.0
            self._feelers[hand].tare(measured.hands[hand - HANDS[0]])
            if self._elapsed > self._motion.stall_time + SETTLE_TIME:
                self._give_up(unreachable=True)
            return
        stuck = self._follow()
        force = self.normal_load(hand, measured)
        if force > self._motion.touch_force:
            self._retargeting.enable(hand, frame_from_normal(self._feelers[hand].normal))
            self._hands.stop(hand)
            self._emit("touched", f"measured {force:.0f} N")
            self._enter("load")
        elif stuck:
            self._give_up(unreachable=True)
        elif path.finished:
            depth = 100 * self._motion.overtravel
            self._give_up(f"no surface down to {depth:.0f} cm below the point: nothing to lean on")

    def _load(self, measured: Measured) -> None:
        force = self.normal_load(self._effector, measured)
        confirmed = force > self._motion.load_confirmed and self._retargeting.loaded(self._effector)
        self._settled = self._settled + self._dt if confirmed else 0.0
        if self._settled >= CONFIRM_TIME:
            self._emit("loaded", f"measured {force:.0f} N")
            self._enter("contact")
        elif self._elapsed > self._motion.load_timeout:
            desired = float(self._retargeting.state.wrenches[self._effector, 2])
            self._emit(
                "aborted",
                f"the hand did not take load within {self._motion.load_timeout:.0f} s: "
                f"desired {desired:.0f} N, measured {force:.0f} N",
            )
            self.goal = None
            self._begin_unload(self._effector)

    def _bumped(self, measured: Measured) -> bool:
        """Stop a reaching hand that touches something: it reaches, it does not push."""
        hand = self._effector
        force = self._feelers[hand].force(measured.hands[hand - HANDS[0]])
        if not force > self._motion.bump_force:
            return False
        self._hands.stop(hand)
        self._hands.targets[hand] += self._motion.bump_retreat * self._away[hand]
        self._bump = True
        return True

    def _reach(self, measured: Measured) -> None:
        distance, motion = self.distance(), self._motion
        if not self._bump:
            self._bumped(measured)
        if self._bump and distance < motion.bump_distance:
            self._emit_new("reached", "touched something at the point", distance)
        elif distance < motion.reached_distance:
            if self._hands.speed(self._effector) < motion.reached_speed:
                self._emit_new("reached", distance=distance)
        elif self._stall.step(self._hands.position(self._effector)):
            blocked = self._bump
            reason = short_by(distance, "something in the way") if blocked else short_by(distance)
            self._emit_new("unreachable", reason, distance)

    def _unload(self, _: Measured) -> None:
        if not self._retargeting.state.enabled[self._effector]:
            self._hands.stop(self._effector)
            self._begin_retreat(self._effector)
        elif self._elapsed > self._motion.unload_timeout:
            left = float(self._retargeting.state.wrenches[self._effector, 2])
            self._retargeting.keep(self._effector)
            reason = (
                f"{left:.0f} N cannot be taken off this hand: the other contacts cannot carry it"
            )
            self._emit("aborted", reason)
            self.goal, self._next, self.releasing_id = None, None, ""
            self._enter("hold")

    def _retreat(self, _: Measured) -> None:
        path = self._path
        stuck = self._follow()
        if path.leg > 0 and self._next is not None:
            self._begin_approach(self._next)
        elif path.finished or stuck:
            self._hands.targets[self._effector] = path.end
            if self.releasing_id:
                self._emit("released")
            self.goal, self.releasing_id = None, ""
            self._enter("hold")

    # --- ends ------------------------------------------------------------------------------------
    def _give_up(self, reason: str = "", *, unreachable: bool = False) -> None:
        """End a contact goal that found no contact, and bring the hand back."""
        distance = self.distance()
        if unreachable:
            reason = short_by(distance)
            self._emit("unreachable", reason, distance)
        self._emit("aborted", reason, distance)
        self.goal = None
        self._begin_retreat(self._effector)
