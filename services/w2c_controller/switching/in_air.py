"""The phases without contact: approach, reach and retreat; and what is felt on the way."""

from w2c_controller.motion.routes import may_cut
from w2c_controller.sensing.loads import Measured
from w2c_controller.switching.events import short_by
from w2c_controller.switching.phases import Phases
from w2c_controller.switching.supervision import Finding


class InAir(Phases):
    """What each of them does in a tick, and how it ends."""

    def _approach(self, _: Measured) -> None:
        goal, travel = self._require_goal(), self._travel
        stuck = travel.follow()
        if goal.task == "reach":
            if stuck and travel.path.leg == 0 and not self._may_cut():
                self._end_effectors.stop(self._effector)
                self._enter("reach")
                return
            if stuck:
                # The way over the surface is out of reach; the point itself may not be.
                travel.next_leg()
            if travel.path.leg > 0 and (travel.path.finished or stuck):
                travel.finish()
                self._enter("reach")
            return
        if travel.path.leg > 0:
            first = travel.path.legs[0]
            self._end_effectors.targets[self._effector] = first.position(first.duration)
            self._enter("touch")
        elif stuck or self._elapsed > self._motion.approach_timeout:
            self._give_up(unreachable=True)

    def _may_cut(self) -> bool:
        k = self._effector
        return may_cut(
            self._terrains[k], self._end_effectors.position(k), self._travel.path.end, self._motion
        )

    def _reach(self, _: Measured) -> None:
        distance, motion = self.distance(), self._motion
        if self._bump and distance < motion.bump_distance:
            self._emit_new("reached", "touched something at the point", distance)
        elif distance < motion.reached_distance:
            if self._end_effectors.speed(self._effector) < motion.reached_speed:
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
        motion = self._motion_of(k)
        at_target = self.phase == "reach" or (self.phase == "approach" and leg > 0)
        limit = motion.bump_force if at_target else motion.air_bump_force
        share = 0.0 if at_target else self._tare_share
        force = self.feelers.feel(k, measured, limit, share)
        self._felt = self._felt + self._sense_period if force > limit else 0.0
        hard = force > motion.air_bump_hard * limit
        stops = self._felt > (0.0 if at_target else motion.air_bump_time)
        self._struck = self._struck + self._sense_period if hard else 0.0
        stops |= self._struck > motion.air_bump_hard_time
        return self._bumped(force, limit) if stops else None

    def _bumped(self, force: float, limit: float) -> Finding | None:
        """Hold what touched something on its way: it reaches, it does not push."""
        k, goal, distance = self._effector, self.goal, self.distance()
        self._end_effectors.stop(k)
        self._end_effectors.targets[k] += self._motion.bump_retreat * self._away[k]
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
