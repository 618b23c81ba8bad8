"""What all phases of a goal share: the parts they work on, how one begins, and how one ends."""

import math
from abc import ABC, abstractmethod
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from w2c_controller.goals.goals import Goal
from w2c_controller.motion.end_effectors import EndEffectors
from w2c_controller.motion.routes import lift, retreat
from w2c_controller.motion.terrain import Terrain
from w2c_controller.motion.travel import Travel
from w2c_controller.parameters import FEET, HANDS, Motion
from w2c_controller.seiko.retargeting import Retargeting
from w2c_controller.sensing.feelers import UP, Feelers
from w2c_controller.switching.blocking import limits_reached
from w2c_controller.switching.bookkeeping import Bookkeeping
from w2c_controller.switching.events import GoalPhase, short_by
from w2c_controller.switching.push import PushCommand
from w2c_controller.switching.stall import Standstill
from w2c_controller.switching.supervision import ContactWatch

Vector = npt.NDArray[np.float64]


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
        air_bump_force=motion.foot_bump_force,
    )


class Phases(Bookkeeping, ABC):
    """Beginnings and ends; what happens in between is in `InAir` and `OnSurface`."""

    def __init__(
        self, retargeting: Retargeting, end_effectors: EndEffectors, sense_period: float
    ) -> None:
        """Begin with whatever contacts the desired state has.

        Args:
            retargeting: Owns the desired state.
            end_effectors: Takes the targets of what is free.
            sense_period: Time between two measurements [s].
        """
        super().__init__()
        parameters = retargeting.parameters
        self._retargeting = retargeting
        self._end_effectors = end_effectors
        self._motion: Motion = parameters.motion
        self._foot_motion = for_feet(parameters.motion)
        self._supervision = parameters.supervision
        self._dt = retargeting.dt
        self._sense_period = sense_period
        self._tare_share = min(sense_period / self._supervision.bump_settle, 1.0)
        """How much of a small force in the air becomes zero in a measurement"""
        self.feelers = Feelers()
        self._contacts: dict[int, Goal] = {}
        """The goals that made the contacts of now"""
        self._away = {k: UP.copy() for k in range(4)}
        """Back the way each came: along the normal of a contact, against reaching fingers"""
        self._terrains: dict[int, Terrain | None] = dict.fromkeys(range(4))
        """What the way back of each must clear, as known when it came"""
        self._travel = Travel(
            end_effectors, self._motion, parameters.filters.lead_position, self._dt
        )
        self._pushes = {k: PushCommand(parameters.push, self._dt) for k in HANDS}
        self._watch = ContactWatch(
            self._supervision,
            parameters.limits.friction,
            retargeting.controlled.hand_radius,
            sense_period,
        )
        self._sensed = 0
        """Measurements so far"""
        self._slipped = [-math.inf] * 4
        """At which of them each contact slipped last"""
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
        self._felt = 0.0
        """For how long it is more than the air's [s]"""
        self._struck = 0.0
        """For how long it is much more [s]"""
        self._stay = False
        """Whether what is unloaded stays where it is afterwards"""
        for k in HANDS:
            if retargeting.state.enabled[k]:
                self.feelers.expect(k, retargeting.state.contact_rotations[k][:, 2])

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

    def _begin_unload(self, effector: int, *, lost: bool = False) -> None:
        self._effector = effector
        self._stay = False
        self._retargeting.state.pushing[effector] = False
        self._retargeting.release(effector, lost=lost)
        self._enter("unload")

    def _begin_retreat(self, effector: int) -> None:
        k = effector
        self._effector = k
        self._tared = self._bump = False
        start, motion = self._end_effectors.position(k), self._motion_of(k)
        if k in FEET:
            self._travel.start(k, lift(start, self._away[k], motion))
        else:
            self._end_effectors.relax(k)
            start, velocity = self._travel.present(k)
            rest = self._end_effectors.rest[k]
            way = retreat(start, self._away[k], rest, motion, velocity, self._terrains[k])
            self._travel.start(k, way)
        self._enter("retreat")

    def _enter(self, phase: GoalPhase) -> None:
        self.phase = phase
        self._elapsed = 0.0
        self._settled = 0.0
        self._felt = self._struck = 0.0
        self._travel.watch_anew()
        self._ramp.reset()

    def _motion_of(self, effector: int) -> Motion:
        return self._foot_motion if effector in FEET else self._motion

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
        where = self._end_effectors.position(self.goal.effector)
        return math.dist(where.tolist(), self.goal.target.tolist())
