"""The states of a goal: approach, touch, load, contact; unload, retreat; reach.

    contact:  hold -> approach -> touch -> load -> contact        what leans stays a support
    reach:    hold -> approach -> reach                           as close as balance allows
    release:  contact -> unload -> retreat -> hold,   reach -> retreat -> hold

A contact is enabled only by a measured touch, never in the air. A hand retreats to where it rests,
a foot is lifted a little and stays there. A hand that leans already and gets another force at the
same place goes from contact to load. Every phase that waits has a limit, and says why it gave up.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from w2c.errors import GoalRefusedError
from w2c.geometry import unit
from w2c_controller.goals.goals import Goal
from w2c_controller.motion.end_effectors import EndEffectors
from w2c_controller.motion.grasp import pointing_rotation
from w2c_controller.motion.routes import approach, way_back
from w2c_controller.parameters import FEET
from w2c_controller.seiko.retargeting import Retargeting
from w2c_controller.sensing.loads import Measured
from w2c_controller.switching.events import Event, GoalPhase
from w2c_controller.switching.on_surface import OnSurface
from w2c_controller.switching.supervision import Finding

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]


class Switching(OnSurface):
    """One goal at a time; hands that lean, or hold a reached point, stay as they are meanwhile."""

    def __init__(
        self, retargeting: Retargeting, end_effectors: EndEffectors, sense_period: float
    ) -> None:
        """Begin with whatever contacts the desired state has.

        Args:
            retargeting: Owns the desired state.
            end_effectors: Takes the targets of what is free.
            sense_period: Time between two measurements [s].
        """
        super().__init__(retargeting, end_effectors, sense_period)
        self._steps: dict[GoalPhase, Callable[[Measured], None]] = {
            "approach": self._approach,
            "touch": self._touch,
            "load": self._load,
            "reach": self._reach,
            "unload": self._unload,
            "retreat": self._retreat,
        }

    def place(self, goal: Goal) -> None:
        """Begin a goal; its end effector leaves its support first where it has one."""
        self._supersede(goal.goal_id)
        state = self._retargeting.state
        if not state.enabled[goal.effector]:
            self._begin_approach(goal)
        elif self._leans_there(goal):
            self._begin_again(goal)
        else:
            self.goal, self._next = goal, goal
            self._begin_unload(goal.effector)

    def release(self, goal_id: str, effector: int) -> None:
        """Take an end effector off its support: a hand comes back, a foot stays lifted."""
        self._supersede(goal_id)
        self._forget_goal()
        self._next, self.releasing_id = None, goal_id
        if self._retargeting.state.enabled[effector]:
            self._begin_unload(effector)
        else:
            self._begin_retreat(effector)

    def abort(self, reason: str) -> None:
        """End the goal under way; contacts stay, and what is free stays where it is. For stop.

        A hand that lost its support goes on being unloaded: there is nothing to keep.
        """
        if self._unfinished() and (self.goal is not None or self.releasing_id):
            self._emit("aborted", reason)
        lost = [k for k in range(4) if self._retargeting.state.lost[k]]
        for k in range(4):
            self._retargeting.keep(k)
            self._end_effectors.stop(k)
        for k, push in self._pushes.items():
            push.reset(float(self._retargeting.state.wrenches[k, 2]))
        self._forget_goal()
        self._next = None
        self._enter("hold")
        for k in lost:
            self._begin_unload(k, lost=True)
            self._stay = True

    def step(self, measured: Measured) -> list[Event]:
        """Advance by one tick; returns what changed."""
        self._elapsed += self._dt
        self._push()
        action = self._steps.get(self.phase)
        if action is not None:
            action(measured)
        return self._log.take()

    def supervise(self, measured: Measured) -> list[Finding]:
        """Look at a new measurement: do contacts hold, does something touch what is in the air.

        The answer begins at once. Goals end and nothing moves on by itself, unless a foot slips
        while a hand comes back: that goes on, back to where the feet bear alike. A hand that lost
        its support, or slips again, is also unloaded in the model, so that the robot comes back
        over what does carry it. Until it is placed anew, a hand that slipped bears along the normal
        alone: that needs no friction.

        Returns:
            What was found, to be told.
        """
        self._sensed += 1
        blocked = self._feel(measured)
        self._note_carriers(measured)
        finding = self._watch.step(self._retargeting.state, self.feelers, measured)
        if finding is not None:
            self._answer(finding)
        return [found for found in (blocked, finding) if found is not None]

    def normal_load(self, effector: int, measured: Measured) -> float:
        """Return the measured normal force [N], without what was read in the air."""
        return self.feelers.normal_force(effector, measured)

    # --- beginnings ------------------------------------------------------------------------------
    def _leans_there(self, goal: Goal) -> bool:
        """Return whether the hand of a goal leans at its point already."""
        k, state = goal.effector, self._retargeting.state
        if k in FEET or state.releasing[k]:
            return False
        places = [state.target_positions[k]]
        if k in self._contacts:
            places.append(self._contacts[k].target)
        normal, within = state.contact_rotations[k][:, 2], self._motion.same_contact
        return any(goal.is_at(place, normal, within) for place in places)

    def _begin_again(self, goal: Goal) -> None:
        """Change the force of a contact that exists."""
        self.goal, self._effector, self.releasing_id = goal, goal.effector, ""
        self._next = None
        self._log.begin()
        self._emit("moving")
        self._begin_load(goal)

    def _begin_approach(self, goal: Goal) -> None:
        k = goal.effector
        self.goal, self._effector, self.releasing_id = goal, k, ""
        self._next = None
        self.feelers.expect(k, goal.normal)
        self._log.begin()
        self._bump = False
        self._tared = False
        self._away[k] = way_back(goal)
        if goal.task == "reach":
            self._end_effectors.rotations[k] = pointing_rotation(-self._away[k])
        elif k in FEET:
            forward = self._retargeting.kinematics.rotations[k][:, 0]
            self._end_effectors.rotations[k] = _sole_on(goal.normal, forward)
        else:
            self._end_effectors.relax(k)
        start, velocity = self._travel.present(k)
        try:
            path = approach(goal, start, velocity, self._motion_of(k))
        except GoalRefusedError as error:
            # The hand has left the place from which the way was planned.
            self._emit("aborted", str(error))
            self._forget_goal()
            self._end_effectors.stop(k)
            self._enter("hold")
            return
        # The way back needs what is known of the terrain; the goal, which is kept long, does not.
        self._terrains[k], self.goal = goal.terrain, replace(goal, terrain=None)
        self._travel.start(k, path)
        self._enter("approach")
        self._emit("moving")

    # --- answers to what was found ---------------------------------------------------------------
    def _answer(self, finding: Finding) -> None:
        """End goals; unload a hand that has no support."""
        k, reason = finding.effector, finding.text()
        if k in FEET and finding.cause == "contact_slips" and self._comes_back():
            # On the way back the weight returns to the foot; to stop would leave it without.
            return
        contact = self._contacts.get(k)
        told_anyway = contact is self.goal and self._unfinished()
        if contact is not None and finding.cause == "contact_lost" and not told_anyway:
            self._log.add(Event(contact.goal_id, k, contact.task, "aborted", reason))
        slips = finding.cause == "contact_slips" and k not in FEET
        again = (
            self._sensed - self._slipped[k]
        ) * self._sense_period < self._supervision.slip_again
        if slips and not again:
            reason += "; from now on it bears along the normal alone"
        self.abort(reason)
        if k in FEET:
            return
        if slips:
            self._slipped[k] = self._sensed
            # With the force that it has: `abort` has just made it the commanded one.
            self._retargeting.state.pushing[k] = True
        if finding.cause == "contact_lost" or (slips and again):
            self._begin_unload(k, lost=finding.cause == "contact_lost")
            self._stay = True

    def _comes_back(self) -> bool:
        """Return whether a hand in the air is on its way back."""
        return self.phase == "retreat" and self._effector not in FEET

    def _note_carriers(self, measured: Measured) -> None:
        """Watch the contacts that were found to carry, as long as they shall."""
        state, watch = self._retargeting.state, self._watch
        for k in range(4):
            wanted = state.enabled[k] and not state.releasing[k]
            if wanted and not watch.watches[k]:
                wanted = self.normal_load(k, measured) > self._supervision.lost_desired[k >= 2]
            if wanted != watch.watches[k]:
                watch.set(k, wanted)


def _sole_on(normal: Vector, forward: Vector) -> Matrix:
    """Return world_from_sole (3, 3) flat on a surface, its x as close to `forward` as may be."""
    x = unit(forward - (forward @ normal) * normal)
    return np.column_stack([x, np.cross(normal, x), normal])
