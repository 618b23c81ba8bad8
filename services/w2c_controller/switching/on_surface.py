"""The phases with contact: touch, load and unload."""

import numpy as np

from w2c.geometry import frame_from_normal
from w2c_controller.goals.goals import Goal
from w2c_controller.sensing.loads import Measured
from w2c_controller.switching.blocking import spoken
from w2c_controller.switching.in_air import InAir

SETTLE_TIME = 0.3
"""Rest above the surface, where the force estimate is tared [s]."""
SETTLE_DISTANCE = 0.015
CONFIRM_TIME = 0.2
"""How long a load must be measured [s]."""
NEAR = 0.015
"""Above the point from here on it comes down slowly [m]: surfaces are known to a centimetre."""
SLOW = 0.3
"""How slowly, as a share of the speed of a touch. What stops at once swings on: at 25 mm/s a hand
hits with 50 N, and is off the surface again for 0.2 s."""
PRESSING = 0.3
"""How much of that is left where it feels all but the force of a touch."""


class OnSurface(InAir):
    """What each of them does in a tick, and how it ends."""

    def _touch(self, measured: Measured) -> None:
        """Rest above the surface and tare, then go down until the surface stops the motion."""
        travel, k, motion = self._travel, self._effector, self._motion_of(self._effector)
        above = travel.path.legs[1].points[0]
        if self._settled < SETTLE_TIME:
            near = float(np.linalg.norm(self._end_effectors.position(k) - above)) < SETTLE_DISTANCE
            self._settled = self._settled + self._dt if near else 0.0
            self.feelers.tare(k, measured)
            if self._elapsed > motion.stall_time + SETTLE_TIME:
                self._give_up(unreachable=True)
            return
        force = self.feelers.normal_force(k, measured)
        stuck = travel.follow(self._pace(force / motion.touch_force))
        if force > motion.touch_force:
            goal = self._require_goal()
            self._retargeting.enable(k, frame_from_normal(goal.normal))
            self._end_effectors.stop(k)
            self._emit("touched", f"measured {force:.0f} N")
            self._begin_load(goal)
        elif stuck:
            self._give_up(unreachable=True)
        elif travel.path.finished:
            depth = 100 * motion.overtravel
            self._give_up(f"no surface down to {depth:.0f} cm below the point: nothing to lean on")

    def _pace(self, felt: float) -> float:
        """Return the share of its speed at which an end effector comes down to its point.

        Args:
            felt: Share of the force that is a touch; what is no number counts as all of it.
        """
        goal, k = self._require_goal(), self._effector
        height = float((self._end_effectors.position(k) - goal.target) @ goal.normal)
        far = min(max((height - NEAR) / NEAR, 0.0), 1.0)
        free = min(max(0.0, 1.0 - felt), 1.0)
        return (SLOW + (1.0 - SLOW) * far) * (PRESSING + (1.0 - PRESSING) * free)

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
            self._end_effectors.stop(k)
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
