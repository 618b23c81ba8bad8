"""Which limits hold a posture back, in words for the operator."""

import numpy as np
import numpy.typing as npt

from w2c_controller.contacts import normal_force_limits
from w2c_controller.desired import DesiredState
from w2c_controller.model import ControlledModel, Kinematics
from w2c_controller.parameters import DEGREE, EFFECTORS, FEET, HANDS, Limits

Vector = npt.NDArray[np.float64]

AT_LIMIT = 0.98
"""Share of a limit that counts as being at it."""
JOINT_TOLERANCE = 0.5 * DEGREE
FORCE_TOLERANCE = 1.0
"""[N]"""


def binding_limits(
    controlled: ControlledModel,
    kinematics: Kinematics,
    state: DesiredState,
    limits: Limits,
    hand: int,
) -> list[str]:
    """Return what keeps a hand from going farther, the most telling first; empty: no hard limit.

    Args:
        controlled: The robot.
        kinematics: Of the state, statics included.
        state: Where the hand is held back.
        limits: Of the Retargeting.
        hand: Index of the hand that shall go farther.
    """
    return [
        *_supports(state, limits),
        *_torques(controlled, kinematics, limits),
        *_joints(controlled, state, limits, hand),
    ]


def _supports(state: DesiredState, limits: Limits) -> list[str]:
    """Return the contacts at the border of what they can bear."""
    words = []
    borders = []
    for k in range(4):
        if not state.enabled[k]:
            continue
        name = EFFECTORS[k].replace("_", " ")
        fx, fy, fz, tx, ty, _ = state.wrenches[k]
        least, most = normal_force_limits(limits, k)
        if fz > most - FORCE_TOLERANCE:
            words.append(f"the {name} bears its maximum of {most:.0f} N")
        tangential = max(abs(fx), abs(fy))
        if tangential > AT_LIMIT * limits.friction * fz:
            words.append(f"friction of the {name}")
        if k in FEET:
            pressed = abs(ty) > AT_LIMIT * limits.cop_x * fz or abs(tx) > (
                AT_LIMIT * limits.cop_y * fz
            )
            if pressed or fz < least + FORCE_TOLERANCE:
                borders.append(f"the {name}")
    if borders:
        words.insert(0, f"balance ({' and '.join(borders)} at the border of the support)")
    return words


def _torques(controlled: ControlledModel, kinematics: Kinematics, limits: Limits) -> list[str]:
    """Return the joints at their torque limit."""
    share = np.abs(kinematics.static[6:]) / (limits.torque_fraction * controlled.effort)
    return [f"the torque of {controlled.joint_names[i]}" for i in np.flatnonzero(share > AT_LIMIT)]


def _joints(
    controlled: ControlledModel, state: DesiredState, limits: Limits, hand: int
) -> list[str]:
    """Return the joints at the end of their range, of the legs, the torso and the hand's arm."""
    other = controlled.joints_of(HANDS[1] if hand == HANDS[0] else HANDS[0]) - 6
    words = []
    for i, name in enumerate(controlled.joint_names):
        if i in other:
            continue
        margin = limits.joint_margin * limits.joint_margin_factors.get(name, 1.0) + JOINT_TOLERANCE
        angle = state.q[7 + i]
        if angle < controlled.lower[i] + margin or angle > controlled.upper[i] - margin:
            words.append(f"the range of {name}")
    return words
