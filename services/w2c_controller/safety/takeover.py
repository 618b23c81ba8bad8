"""How the controller begins with a robot: standing, or leaning already."""

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from w2c.geometry import frame_from_normal
from w2c.messages import ControllerSnapshot, RobotState
from w2c_controller.kinematics.model import standing_configuration
from w2c_controller.parameters import EFFECTORS, HANDS
from w2c_controller.safety.hazards import Hazard, Holds
from w2c_controller.safety.stop import Stop
from w2c_controller.seiko.retargeting import Retargeting
from w2c_controller.sensing.loads import Measured
from w2c_controller.snapshots.snapshot import BODY, HOLDS, STOP, refusal
from w2c_controller.snapshots.state_tree import SnapshotError, restore
from w2c_controller.whole_body import WholeBody

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]

FRESH_POSTURE = 0.05
"""A robot within this of its initial posture starts from it exactly [rad]."""
LEANING_FORCE = 15.0
"""A hand that measures more at the start leans [N]."""
HANGING = -0.7
"""A force whose vertical share is below this is a load that hangs on the hand, no support."""


def find_supports(measured: Measured) -> dict[int, Matrix]:
    """Return the hands that bear weight, each with its world_from_contact (3, 3)."""
    supports = {}
    for row, k in enumerate(HANDS):
        force = measured.hands[row]
        size = float(np.linalg.norm(force))
        if size > LEANING_FORCE and force[2] > HANGING * size:
            supports[k] = frame_from_normal(force)
    return supports


def starting_posture(joints: Vector, initial: Vector, supports: Mapping[int, Matrix]) -> Vector:
    """Return the joint angles (n,) to start from: the initial ones where the robot stands there."""
    fresh = not supports and float(np.max(np.abs(joints - initial))) < FRESH_POSTURE
    return initial if fresh else joints


def unknown_contacts(
    supports: Mapping[int, Matrix], measured: Measured, refusal: str = ""
) -> Hazard:
    """Return what forbids to start: hands bear weight, and nobody knows why.

    Args:
        supports: The hands, with their frames.
        measured: Loads.
        refusal: Why the snapshot that there is does not count.
    """
    forces = {k: float(np.linalg.norm(measured.hands[k - HANDS[0]])) for k in supports}
    hands = ", ".join(
        f"{EFFECTORS[k].replace('_', ' ')} {force:.0f} N" for k, force in forces.items()
    )
    missing = f"the snapshot does not count: {refusal}" if refusal else "there is no snapshot"
    text = f"hands bear weight ({hands}) and {missing}"
    heaviest = max(forces, key=lambda k: forces[k])
    return Hazard("no_snapshot", text, EFFECTORS[heaviest], forces[heaviest], LEANING_FORCE, "N")


def follow_command(retargeting: Retargeting, change: Vector) -> None:
    """Move the desired posture by what the command in force moved since a snapshot.

    Feet that stand have not moved meanwhile, and carry the base along; what the posture asks of a
    leaning hand beyond its place is removed within the limits of the Retargeting.

    Args:
        retargeting: As it was in the snapshot.
        change: (nj,) [rad].
    """
    state, controlled = retargeting.state, retargeting.controlled
    joints = np.clip(state.q[7:] + change, controlled.lower, controlled.upper)
    if state.enabled[0] and state.enabled[1]:
        state.q[:] = standing_configuration(controlled, joints)
    else:
        state.q[7:] = joints
    retargeting.kinematics.update_frames(state.q)


class Takeover:
    """Begins with a robot: from a snapshot, standing, or leaning where an operator says so."""

    def __init__(self, body: WholeBody, joint_indices: Indices) -> None:
        """Begin with nothing.

        Args:
            body: Of the robot.
            joint_indices: (nj,) where its joints stand in vectors of the bus.
        """
        self._body = body
        self._indices = joint_indices
        self._offered: tuple[ControllerSnapshot, str] | None = None
        self._inherited = False
        self.adopts = False
        """Whether hands that bear weight are supports, on the word of an operator"""
        self.done = False
        self.how = ""
        """In words, for the log"""

    def offer(self, snapshot: ControllerSnapshot, robot_boot_id: str) -> None:
        """Take the newest snapshot of a controller that is no more, and the robot's boot id now."""
        self._offered = snapshot, robot_boot_id

    def attempt(self, state: RobotState, holds: Holds, stop: Stop) -> None:
        """Begin with a robot in this state, or hold until that is possible.

        Args:
            state: Of the robot now.
            holds: Filled with what made the last controller wait for an operator, whether its
                snapshot fits or not.
            stop: As above.

        Raises:
            ControlError: the posture cannot stand.
        """
        self._inherit(state, holds, stop)
        body, joints = self._body, state.position[self._indices]
        measured = body.weigh(state)
        why_not = self._from_snapshot(state, measured)
        if self.done:
            return
        supports = find_supports(measured)
        if supports and not self.adopts:
            holds.found(unknown_contacts(supports, measured, why_not), state.tick)
            return
        posture = starting_posture(joints, body.initial_joints, supports)
        body.begin(posture, supports, state.command, measured)
        self.how = f"leaning with {len(supports)} hands" if supports else "standing"
        self.done = True

    def _inherit(self, state: RobotState, holds: Holds, stop: Stop) -> None:
        """Wait for an operator where the last controller of this robot did."""
        if self._offered is None or self._inherited:
            return
        self._inherited = True
        snapshot, robot_boot_id = self._offered
        if snapshot.robot_boot_id != robot_boot_id or snapshot.tick > state.tick:
            return
        last_holds, last_stop = Holds(0.0), Stop()
        try:
            restore(last_holds, snapshot.state[HOLDS])
            restore(last_stop, snapshot.state[STOP])
        except (KeyError, SnapshotError) as error:
            stop.ask(f"whether the last controller held cannot be read: {error}")
            return
        holds.inherit(last_holds, state.tick)
        stop.inherit(last_stop)

    def _from_snapshot(self, state: RobotState, measured: Measured) -> str:
        """Go on where another controller was, contacts kept; returns why not, "" = done or none."""
        if self._offered is None:
            return ""
        snapshot, robot_boot_id = self._offered
        why_not = refusal(snapshot, state, robot_boot_id, measured)
        if why_not:
            return why_not
        self._offered = None
        body = self._body
        body.begin(body.initial_joints, {}, state.command)
        try:
            restore(body, snapshot.state[BODY])
        except (KeyError, SnapshotError) as error:
            return f"it does not fit: {error}"
        body.measured = measured
        change = (state.command - snapshot.command)[self._indices]
        if change.any():
            follow_command(body.retargeting, change)
            body.force_control.settle(body.retargeting)
        self.how = f"from the snapshot of tick {snapshot.tick}"
        self.done = True
        return ""
