"""Limits of the Retargeting QP, compiled: joints, torques, wrenches and their cones."""

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]


@compiled
def fill_bounds(
    dt: float,
    q: Vector,
    torque: Vector,
    wrench: Vector,
    force_min: Vector,
    force_max: Vector,
    joint_lower: Vector,
    joint_upper: Vector,
    velocity: Vector,
    effort: Vector,
    rates: Vector,
    contacts: Indices,
    rows: Matrix,
    first_row: int,
    lower: Vector,
    upper: Vector,
) -> None:
    """Fill limits of joints, wrenches, torques and cones; x = 0 stays inside all of them.

    `first_row` is that of the torques, which the cones follow; `wrench` and its largest `rates`
    (nl,) stack all contacts; `force_min` and `force_max` (4,) bound normal forces, `velocity` and
    `effort` (nj,) are the largest of each joint.
    """
    nj, n = torque.shape[0], rows.shape[1]
    nv = 6 + nj
    for i in range(nj):
        angle = q[7 + i]
        upper[6 + i] = max(min(velocity[i], (joint_upper[i] - angle) / dt), 0.0)
        lower[6 + i] = min(max(-velocity[i], (joint_lower[i] - angle) / dt), 0.0)
        upper[n + first_row + i] = max((effort[i] - torque[i]) / dt, 0.0)
        lower[n + first_row + i] = min((-effort[i] - torque[i]) / dt, 0.0)
    for i in range(n - nv):
        upper[nv + i] = rates[i]
        lower[nv + i] = -rates[i]
    for c in range(contacts.shape[0]):
        k, normal = contacts[c, 0], contacts[c, 1] + 2
        force = wrench[normal - nv]
        upper[normal] = max(min(upper[normal], (force_max[k] - force) / dt), 0.0)
        lower[normal] = min(max(lower[normal], (force_min[k] - force) / dt), 0.0)
    for r in range(first_row + nj, rows.shape[0]):
        inside = 0.0
        for j in range(n - nv):
            inside -= rows[r, nv + j] * wrench[j]
        upper[n + r] = max(inside / dt, 0.0)
