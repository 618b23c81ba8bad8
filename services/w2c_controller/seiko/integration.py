"""What the Retargeting does with a solution: one period of posture, wrenches and force minima."""

from typing import Final

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled
from w2c_controller.kinematics.configuration import integrate
from w2c_controller.seiko.rolling import roll

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]
Flags = tuple[bool, bool, bool, bool]

FORCE_MIN_SLACK: Final = 0.01
"""How far the growing minimum of a new contact stays below its force [N]."""


@compiled
def advance(
    dt: float,
    scale: float,
    x: Vector,
    lower: Vector,
    upper: Vector,
    static: Vector,
    torque_rows: Matrix,
    jacobians: Matrix,
    supports: Indices,
    levers: Matrix,
    contacts: Indices,
    releasing: Flags,
    joint_lower: Vector,
    joint_upper: Vector,
    force_min_wanted: Vector,
    lightest: Vector,
    q: Vector,
    velocity: Vector,
    torque: Vector,
    wrenches: Matrix,
    force_min: Vector,
    target_positions: Matrix,
) -> int:
    """Move posture q, wrenches (4, 6), force minima (4,) and places of balls by one period.

    The minimum of a new contact grows with its force, up to the configured one (4,), so that it is
    never infeasible. `lower` and `upper` (n,) are the limits of x: a solver may exceed them by
    rounding.

    Returns:
        Which released contacts carry less than `lightest` (4,): the sum of 1 << contact.
    """
    nv = velocity.shape[0]
    for i in range(x.shape[0]):
        x[i] = scale * min(max(x[i], lower[i]), upper[i])
    for i in range(nv):
        velocity[i] = x[i]
    for i in range(torque.shape[0]):
        change = 0.0
        for j in range(x.shape[0]):
            change += torque_rows[i, j] * x[j]
        torque[i] = static[6 + i] + dt * change
    roll(dt, velocity, jacobians, supports, levers, contacts, target_positions)
    integrate(q, velocity, dt, q)
    for i in range(torque.shape[0]):
        q[7 + i] = min(max(q[7 + i], joint_lower[i]), joint_upper[i])
    light = 0
    for c in range(contacts.shape[0]):
        k = contacts[c, 0]
        for j in range(contacts[c, 2]):
            wrenches[k, j] += dt * x[contacts[c, 1] + j]
        normal = wrenches[k, 2]
        if releasing[k]:
            if normal < lightest[k]:
                light += 1 << k
        elif force_min[k] < force_min_wanted[k]:
            reached = min(normal - FORCE_MIN_SLACK, force_min_wanted[k])
            force_min[k] = max(force_min[k], reached)
    return light
