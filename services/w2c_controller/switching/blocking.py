"""Which limits the desired state is at: what stops a ramp or a motion, in words."""

import math

import numpy as np

from w2c_controller.parameters import EFFECTORS, FEET, Limits
from w2c_controller.seiko.contacts import normal_force_limits
from w2c_controller.seiko.retargeting import Retargeting

NEAR = 0.97
"""Share of a limit that counts as being at it."""
NEAR_ANGLE = 0.002
"""[rad]"""
MOST = 4
"""More reasons than this do not help."""


def limits_reached(retargeting: Retargeting) -> list[str]:
    """Return the limits that the desired state is at, contacts first; at most `MOST`."""
    found: list[str] = []
    for k, enabled in enumerate(retargeting.state.enabled):
        if enabled:
            found += _contact(retargeting, k)
    return (found + _torques(retargeting) + _angles(retargeting))[:MOST]


def spoken(effector: int) -> str:
    """Return the name of an end effector as people say it."""
    return EFFECTORS[effector].replace("_", " ")


def _contact(retargeting: Retargeting, contact: int) -> list[str]:
    """Return the limits of one contact's wrench."""
    limits, name = retargeting.parameters.limits, spoken(contact)
    wrench = retargeting.state.wrenches[contact]
    x, y, normal = (float(value) for value in wrench[:3])
    least, most = normal_force_limits(limits, contact)
    found = []
    if normal > NEAR * most:
        found.append(f"the {name} carries {normal:.0f} N, its most is {most:.0f} N")
    releasing = retargeting.state.releasing[contact]
    if contact in FEET and not releasing and normal * NEAR < least:
        found.append(f"the {name} carries {normal:.0f} N, its least is {least:.0f} N")
    bound = limits.friction * normal
    if max(abs(x), abs(y)) > NEAR * bound and bound > 1.0:
        found.append(
            f"the {name} is at its friction limit ({math.hypot(x, y):.0f} N along the surface, "
            f"{limits.friction:g} of {normal:.0f} N)"
        )
    if contact in FEET and normal > least:
        found += _pressure(limits, name, wrench.tolist())
    return found


def _pressure(limits: Limits, name: str, wrench: list[float]) -> list[str]:
    """Return whether the centre of pressure is at the border of its area in the sole."""
    along, across = -wrench[4] / wrench[2], wrench[3] / wrench[2]
    sides = []
    if abs(along) > NEAR * limits.cop_x:
        sides.append("front" if along > 0 else "back")
    if abs(across) > NEAR * limits.cop_y:
        sides.append("left" if across > 0 else "right")
    if not sides:
        return []
    return [f"the {name} presses at the {' and '.join(sides)} of its area: the end of balance"]


def _torques(retargeting: Retargeting) -> list[str]:
    controlled = retargeting.controlled
    fraction = retargeting.parameters.limits.torque_fraction
    limit = fraction * controlled.effort
    torque = np.abs(retargeting.state.torque)
    return [
        f"{controlled.joint_names[i]} bears {torque[i]:.1f} Nm, its limit is {limit[i]:.1f} Nm "
        f"({fraction:.0%} of its effort)"
        for i in np.flatnonzero(torque > NEAR * limit)
    ]


def _angles(retargeting: Retargeting) -> list[str]:
    controlled, limits = retargeting.controlled, retargeting.parameters.limits
    found = []
    for i, name in enumerate(controlled.joint_names):
        margin = limits.joint_margin * limits.joint_margin_factors.get(name, 1.0)
        angle = float(retargeting.state.q[7 + i])
        low, high = float(controlled.lower[i]) + margin, float(controlled.upper[i]) - margin
        if angle < low + NEAR_ANGLE or angle > high - NEAR_ANGLE:
            limit = low if angle < low + NEAR_ANGLE else high
            found.append(f"{name} is at its limit of {math.degrees(limit):.0f} degrees")
    return found
