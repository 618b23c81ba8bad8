"""How the controller begins with a robot: standing, or leaning already."""

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from w2c.geometry import frame_from_normal
from w2c_controller.model import standing_configuration
from w2c_controller.parameters import EFFECTORS, HANDS
from w2c_controller.retargeting import Retargeting
from w2c_controller.safety import Hazard
from w2c_controller.sensing import Measured

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]

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
