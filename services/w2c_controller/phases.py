"""What each phase of a goal does in a tick, and how it ends."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from w2c.geometry import frame_from_normal
from w2c_controller.blocking import limits_reached, spoken
from w2c_controller.bookkeeping import Bookkeeping
from w2c_controller.events import GoalPhase, short_by
from w2c_controller.feelers import UP, Feelers
from w2c_controller.goals import Goal
from w2c_controller.hands import Hands
from w2c_controller.parameters import FEET, HANDS, Motion
from w2c_controller.push import PushCommand
from w2c_controller.retargeting import Retargeting
from w2c_controller.routes import lift, retreat
from w2c_controller.sensing import Measured
from w2c_controller.stall import Standstill
from w2c_controller.supervision import ContactWatch, Finding
from w2c_controller.terrain import Terrain
from w2c_controller.travel import Travel

Vector = npt.NDArray[np.float64]

SETTLE_TIME = 0.3
"""Rest above the surface, where the force estimate is tared [s]."""
SETTLE_DISTANCE = 0.015
CONFIRM_TIME = 0.2
"""How long a load must be measured [s]."""


def for_feet(motion: Motion) -> Motion:
    """Return how a foot moves and touches, in the words of a hand."""
    return replace(
        motion,
        speed=motion.foot_speed,
        via_height=motion.foot_lift,
        retreat_height=motion.foot_lift,
        touch_force=motion.foot_touch_force,
        load_confirmed=motion.foot_load_confirmed,
        bump_force=motion.foot_bump_force,
    )


class Phases(Bookkeeping, ABC):
    """The steps; `Switching` begins them and answers what is found of the contacts."""

    def __init__(self, retargeting: Retargeting, hands: Hands, sense_period: float) -> None:
        """Begin with whatever contacts the desired state has.

        Args:
            retargeting: Owns the desired state.
            hands: Takes the targets of what is free.
            sense_period: Time between two measurements [s].
        """
        super().__init__()
        parameters = retargeting.parameters
        self._retargeting = retargeting
        self._hands = hands
        self._motion: Motion = parameters.motion
        self._foot_motion = for_feet(parameters.motion)
        self._supervision = parameters.supervision
        self._dt = retargeting.dt
        self._sense_period = sense_period
        self.feelers = Feelers()
        self._contacts: dict[int, Goal] = {}
        """The goals that made the contacts of now"""
        self._away = dict.fromkeys(range(4), UP)
        """Back the way each came: along the normal of a contact, against reaching fingers"""
        self._terrains: dict[int, Terrain | None] = dict.fromkeys(range(4))
        """What the way back of each must clear, as known when it came"""
        self._travel = Travel(hands, self._motion, parameters.filters.lead_position, self._dt)
        self._pushes = {k: PushCommand(parameters.push, self._dt) for k in HANDS}
        self._watch = ContactWatch(self._supervision, sense_period)
        self._slipped = [float("inf")] * 4
        """How long ago each contact slipped [s]"""
        self._ramp = Standstill(
            self._motion.ramp_stall_force, self._motion.ramp_stall_time, self._dt
        )
        self._next: Goal | None = None
        self._elapsed = 0.0
        self._settled = 0.0
        self._bump = False
        """Whether a reaching hand touched something on its way"""
        self._tared = False
        """Whether the force in the air of what moves is known"""
        self._stay = False
        """Whether what is unloaded stays where it is afterwards"""
        for k in HANDS:
            if retargeting.state.enabled[k]:
                self.feelers.expect(k, retargeting.state.contact_rotations[k][:, 2])
        self._steps: dict[GoalPhase, Callable[[Measured], None]] = {
            "approach": self._approach,
            "touch": self._touch,
            "load": self._load,
            "reach": self._reach,
            "unload": self._unload,
            "retreat": self._retreat,
        }

    # --- beginnings ------------------------------------------------------------------------------
    @abstractmethod
    def _begin_approach(self, goal: Goal) -> None:
        """Begin the way to a goal."""

    def _begin_load(self, goal: Goal) -> None:
        """Let the force of a contact grow to its share, or to what was commanded."""
        k, state = goal.effector, self._retargeting.state
        self._contacts[k] = goal
        if k in self._pushes:
            push = self._pushes[k]
            if not state.pushing[k]:
                push.reset(float(state.wrenches[k, 2]))
            push.goal = goal.force
            state.push_force[k] = push.target
            state.pushing[k] = goal.force > 0.0
        self._enter("load")

    def _begin_unload(self, effector: int) -> None:
        self._effector = effector
        self._stay = False
        self._retargeting.state.pushing[effector] = False
        self._retargeting.release(effector)
        self._enter("unload")

    def _begin_retreat(self, effector: int) -> None:
        k = effector
        self._effector = k
        self._tared = False
        start, motion = self._hands.position(k), self._motion_of(k)
        if k in FEET:
            self._travel.start(k, lift(start, self._away[k], motion))
        else:
            self._hands.relax(k)
            start, velocity = self._travel.present(k)
            rest = self._hands.rest[k]
            way = retreat(start, self._away[k], rest, motion, velocity, self._terrains[k])
            self._travel.start(k, way)
        self._enter("retreat")

    def _enter(self, phase: GoalPhase) -> None:
        self.phase = phase
        self._elapsed = 0.0
        self._settled = 0.0
        self._travel.watch_anew()
        self._ramp.reset()

    def _motion_of(self, effector: int) -> Motion:
        return self._foot_motion if effector in FEET else self._motion

    # --- in the air ------------------------------------------------------------------------------
    def _approach(self, _: Measured) -> None:
        goal, travel = self._require_goal(), self._travel
        stuck = travel.follow()
        if goal.task == "reach":
            if stuck:
                # The way over the surface is out of reach; the point itself may not be.
                travel.next_leg()
            if travel.path.leg > 0 and (travel.path.finished or stuck):
                travel.finish()
                self._enter("reach")
            return
        if travel.path.leg > 0:
            first = travel.path.legs[0]
            self._hands.targets[self._effector] = first.position(first.duration)
            self._enter("touch")
        elif stuck or self._elapsed > self._motion.approach_timeout:
            self._give_up(unreachable=True)

    def _reach(self, _: Measured) -> None:
        distance, motion = self.distance(), self._motion
        if self._bump and distance < motion.bump_distance:
            self._emit_new("reached", "touched something at the point", distance)
        elif distance < motion.reached_distance:
            if self._hands.speed(self._effector) < motion.reached_speed:
                self._emit_new("reached", distance=distance)
        elif self._travel.rests() and not self._log.told("unreachable"):
            if self._bump:
                reason = short_by(distance, "something in the way")
            else:
                reason = short_by(distance) + self._because()
            self._emit_new("unreachable", reason, distance)

    def _retreat(self, _: Measured) -> None:
        travel = self._travel
        stuck = travel.follow()
        ended = travel.path.finished or stuck
        if self._next is not None and (travel.path.leg > 0 or ended):
            self._begin_approach(self._next)
        elif ended:
            travel.finish()
            if self.releasing_id:
                self._emit("released")
            self._forget_goal()
            self._enter("hold")

    def _feel(self, measured: Measured) -> Finding | None:
        """Stop what moves in the air and touches something; returns what is to be told."""
        leg, k = self._travel.path.leg, self._effector
        leaves = self.phase == "retreat" and leg == 0
        in_air = self.phase in ("approach", "retreat", "reach") and not leaves
        if not in_air or self._bump:
            return None
        if not self._tared:
            self.feelers.tare(k, measured)
            self._tared = True
        limit = self._motion_of(k).bump_force
        force = self.feelers.force(k, measured)
        if force > limit:
            return self._bumped(force, limit)
        at_target = self.phase == "reach" or (self.phase == "approach" and leg > 0)
        if not at_target:
            share = min(self._sense_period / self._supervision.bump_settle, 1.0)
            self.feelers.follow(k, measured, share)
        return None

    def _bumped(self, force: float, limit: float) -> Finding | None:
        """Hold what touched something on its way: it reaches, it does not push."""
        k, goal, distance = self._effector, self.goal, self.distance()
        self._hands.stop(k)
        self._hands.targets[k] += self._motion.bump_retreat * self._away[k]
        finding = Finding("contact_unexpected", k, force, limit)
        if goal is not None and goal.task == "reach":
            self._bump = True
            self._enter("reach")
            return None if distance < self._motion.bump_distance else finding
        where = f", {100 * distance:.0f} cm before the point" if goal is not None else ""
        self._emit("aborted", f"{finding.text()}{where}; it stays there", distance)
        self._forget_goal()
        self._next = None
        self._enter("hold")
        return finding

    # --- on the surface --------------------------------------------------------------------------
    def _touch(self, measured: Measured) -> None:
        """Rest above the surface and tare, then go down until the surface stops the motion."""
        travel, k, motion = self._travel, self._effector, self._motion_of(self._effector)
        above = travel.path.legs[1].points[0]
        if self._settled < SETTLE_TIME:
            near = float(np.linalg.norm(self._hands.position(k) - above)) < SETTLE_DISTANCE
            self._settled = self._settled + self._dt if near else 0.0
            self.feelers.tare(k, measured)
            if self._elapsed > motion.stall_time + SETTLE_TIME:
                self._give_up(unreachable=True)
            return
        stuck = travel.follow()
        force = self.feelers.normal_force(k, measured)
        if force > motion.touch_force:
            goal = self._require_goal()
            self._retargeting.enable(k, frame_from_normal(goal.normal))
            self._hands.stop(k)
            self._emit("touched", f"measured {force:.0f} N")
            self._begin_load(goal)
        elif stuck:
            self._give_up(unreachable=True)
        elif travel.path.finished:
            depth = 100 * motion.overtravel
            self._give_up(f"no surface down to {depth:.0f} cm below the point: nothing to lean on")

    def _load(self, measured: Measured) -> None:
        goal, k = self._require_goal(), self._effector
        force = self.feelers.normal_force(k, measured)
        desired = float(self._retargeting.state.wrenches[k, 2])
        ramped, confirmed = self._loaded(goal, desired, force)
        self._settled = self._settled + self._dt if ramped and confirmed else 0.0
        stalled = self._ramp.step(desired) and not ramped
        patience = self._motion.load_timeout + goal.force / self._retargeting.parameters.push.rate
        if self._settled >= CONFIRM_TIME:
            self._emit("loaded", f"measured {force:.0f} N")
            self._enter("contact")
        elif stalled or self._elapsed > patience:
            self._fail_load(goal, desired, force)

    def _loaded(self, goal: Goal, desired: float, force: float) -> tuple[bool, bool]:
        """Return whether the desired and the measured normal force are what the goal wants."""
        if goal.force > 0.0:
            push = self._retargeting.parameters.push
            tolerance = max(push.tolerance, push.tolerance_share * goal.force)
            ramped = abs(desired - goal.force) < push.desired_tolerance
            return ramped, abs(force - goal.force) < tolerance
        ramped = self._retargeting.loaded(goal.effector)
        return ramped, force > self._motion_of(goal.effector).load_confirmed

    def _fail_load(self, goal: Goal, desired: float, force: float) -> None:
        """Say what a contact did not take; one that carried before stays, with the force it has."""
        k = goal.effector
        wanted = f" of {goal.force:.0f} N" if goal.force > 0.0 else ""
        self._emit(
            "aborted",
            f"the {spoken(k)} did not take its load{wanted} within {self._elapsed:.0f} s: desired "
            f"{desired:.0f} N, measured {force:.0f} N{self._because()}",
        )
        self._forget_goal()
        if force > self._motion_of(k).load_confirmed:
            if k in self._pushes:
                self._pushes[k].goal = desired
            self._enter("hold")
        else:
            self._begin_unload(k)

    def _push(self) -> None:
        """Move the targets of hands that push."""
        state = self._retargeting.state
        for k, push in self._pushes.items():
            if state.pushing[k]:
                state.push_force[k] = push.step(float(state.wrenches[k, 2]))

    def _unload(self, _: Measured) -> None:
        k, state = self._effector, self._retargeting.state
        if not state.enabled[k]:
            self._hands.stop(k)
            self._contacts.pop(k, None)
            if self._stay:
                self._forget_goal()
                self._enter("hold")
            else:
                self._begin_retreat(k)
            return
        left = float(state.wrenches[k, 2])
        if self._ramp.step(left) or self._elapsed > self._motion.unload_timeout:
            self._retargeting.keep(k)
            self._emit(
                "aborted",
                f"{left:.0f} N cannot be taken off the {spoken(k)}: the other contacts cannot "
                f"carry it{self._because()}",
            )
            self._forget_goal()
            self._next = None
            self._enter("hold")

    # --- ends ------------------------------------------------------------------------------------
    def _give_up(self, reason: str = "", *, unreachable: bool = False) -> None:
        """End a contact goal that found no contact, and bring the end effector back."""
        distance = self.distance()
        if unreachable:
            reason = short_by(distance) + self._because()
            self._emit("unreachable", reason, distance)
        self._emit("aborted", reason, distance)
        self._forget_goal()
        self._begin_retreat(self._effector)

    def _because(self) -> str:
        """Return the limits that the desired state is at, as the end of a sentence."""
        found = limits_reached(self._retargeting)
        return f"; held back: {'; '.join(found)}" if found else ""

    def distance(self) -> float:
        """Return what is left between end effector and target [m]; -1 without a goal."""
        if self.goal is None:
            return -1.0
        where = self._hands.position(self.goal.effector)
        return float(np.linalg.norm(where - self.goal.target))
