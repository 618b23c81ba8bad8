"""Assembly of the Retargeting QP, compiled: only entries that depend on the tick are written.

A joint's torque depends on the joints between base and tips through it, and on the wrenches of the
end effectors beyond it: a row of T has about fifteen entries other than zero, whose columns the
layout lists. Costs are summed over those alone, into the upper triangle of H.
"""

from typing import Final

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled
from w2c_controller.kinematics.rotations import rotation_between

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]

POSTURE: Final = 0
POSITION: Final = 1
ROTATION: Final = 2
BIAS_FORCE: Final = 3
BIAS_TORQUE: Final = 4
BIAS_POSITION: Final = 5
BIAS_ROTATION: Final = 6
CLAMPS: Final = 7
"""Where each clamp stands in the vector of clamps, and how many there are."""


@compiled
def clamped_share(x: float, y: float, z: float, limit: float) -> float:
    """Return the factor, at most 1, that brings the length of (x, y, z) to the limit."""
    length = np.sqrt(x * x + y * y + z * z)
    return limit / length if length > limit else 1.0


@compiled
def fill_drifts(
    positions: Matrix,
    rotations: Matrix,
    target_positions: Matrix,
    target_rotations: Matrix,
    drifts: Matrix,
) -> None:
    """Fill what is left to the target of each end effector (4, 6): p* - p, log(R* R^T)."""
    for k in range(4):
        for i in range(3):
            drifts[k, i] = target_positions[k, i] - positions[k, i]
        rotation_between(target_rotations[k], rotations[k], drifts[k, 3:])


@compiled
def fill_torque_rows(
    static_dq: Matrix,
    static_dl: Matrix,
    columns: Indices,
    contacts: Indices,
    first_row: int,
    rows: Matrix,
) -> None:
    """Fill the rows T_J = dtau/dx of all joints.

    Args:
        static_dq: (nv, nv)
        static_dl: (4, nv, 6)
        columns: (nj, n) that are not zero in each row, ascending, then -1.
        contacts: (nc, 3) end effector, first variable, number of variables.
        first_row: Of the torques among the rows of the program.
        rows: (m, n)
    """
    nv = static_dq.shape[0]
    for i in range(columns.shape[0]):
        row = rows[first_row + i]
        for j in columns[i]:
            if j < 0 or j >= nv:
                break
            row[j] = static_dq[6 + i, j]
        for c in range(contacts.shape[0]):
            start = contacts[c, 1]
            for j in range(contacts[c, 2]):
                row[start + j] = static_dl[contacts[c, 0], 6 + i, j]


@compiled
def add_square(
    row: Vector,
    columns: Indices,
    weight: float,
    goal: float,
    hessian: Matrix,
    gradient: Vector,
) -> None:
    """Add w |row x - goal|^2 / 2 to the cost; only the listed columns (ascending) are not zero."""
    for a in range(columns.shape[0]):
        i = columns[a]
        if i < 0:
            break
        share = weight * row[i]
        gradient[i] -= share * goal
        for b in range(a, columns.shape[0]):
            j = columns[b]
            if j < 0:
                break
            hessian[i, j] += share * row[j]


@compiled
def fill_cost(
    dt: float,
    q: Vector,
    posture: Vector,
    static: Vector,
    jacobians: Matrix,
    drifts: Matrix,
    wrench: Vector,
    wrench_goal: Vector,
    rows: Matrix,
    first_row: int,
    columns: Indices,
    supports: Indices,
    diagonal: Vector,
    posture_weight: float,
    momentum_weight: float,
    base_coupling: Matrix,
    torque_weights: Vector,
    pose_weights: Matrix,
    clamps: Vector,
    hessian: Matrix,
    gradient: Vector,
) -> None:
    """Fill H (upper triangle) and g.

    `wrench` and `wrench_goal` (nl,) stack all contacts; `columns` are those of `fill_torque_rows`,
    `supports` (4, nv) the columns of v that move each end effector, then -1; `diagonal` (n,) are
    the weights on the variables themselves, `pose_weights` (4, 2) those of position and rotation.
    """
    n, nv = gradient.shape[0], static.shape[0]
    for i in range(n):
        gradient[i] = 0.0
        for j in range(i, n):
            hessian[i, j] = 0.0
        hessian[i, i] = diagonal[i]
    for i in range(6):
        for j in range(i, nv):
            hessian[i, j] += momentum_weight * base_coupling[i, j]
    for i in range(6, nv):
        error = min(max(posture[i - 6] - q[i + 1], -clamps[POSTURE]), clamps[POSTURE])
        gradient[i] -= posture_weight / dt * error
        add_square(
            rows[first_row + i - 6],
            columns[i - 6],
            torque_weights[i - 6],
            -static[i] / dt,
            hessian,
            gradient,
        )
    for i in range(n - nv):
        gradient[nv + i] += diagonal[nv + i] * (wrench[i] - wrench_goal[i]) / dt
    for k in range(4):
        for half in range(2):
            if pose_weights[k, half] == 0.0:
                continue
            d = drifts[k, 3 * half : 3 * half + 3]
            rate = clamped_share(d[0], d[1], d[2], clamps[POSITION + half]) / dt
            for i in range(3):
                add_square(
                    jacobians[k, 3 * half + i],
                    supports[k],
                    pose_weights[k, half],
                    rate * d[i],
                    hessian,
                    gradient,
                )


@compiled
def fill_equalities(
    dt: float,
    static: Vector,
    static_dq: Matrix,
    static_dl: Matrix,
    jacobians: Matrix,
    point_jacobians: Matrix,
    drifts: Matrix,
    contacts: Indices,
    supports: Indices,
    clamps: Vector,
    rows: Matrix,
    lower: Vector,
    upper: Vector,
) -> int:
    """Fill contacts that stick, and the equilibrium of the base; bounded corrections.

    They are the first of `rows` (m, n), `lower` and `upper` (m,) both their right-hand sides. A
    sole stays where it is; of a hand the point that touches is at rest (`point_jacobians`).

    Returns:
        The number of equalities.
    """
    row = 0
    for c in range(contacts.shape[0]):
        k, size = contacts[c, 0], contacts[c, 2]
        jacobian = jacobians[k] if k < 2 else point_jacobians[k - 2]
        for half in range(size // 3):
            d = drifts[k, 3 * half : 3 * half + 3]
            rate = clamped_share(d[0], d[1], d[2], clamps[BIAS_POSITION + half]) / dt
            for i in range(3):
                lower[row] = upper[row] = rate * d[i]
                for j in supports[k]:
                    if j < 0:
                        break
                    rows[row, j] = jacobian[3 * half + i, j]
                row += 1
    for half in range(2):
        s = static[3 * half : 3 * half + 3]
        rate = -clamped_share(s[0], s[1], s[2], clamps[BIAS_FORCE + half]) / dt
        for i in range(3):
            lower[row] = upper[row] = rate * s[i]
            # A moved base changes nothing: the columns of its linear velocity are zero.
            for j in range(3, static.shape[0]):
                rows[row, j] = static_dq[3 * half + i, j]
            for c in range(contacts.shape[0]):
                for j in range(contacts[c, 2]):
                    rows[row, contacts[c, 1] + j] = static_dl[contacts[c, 0], 3 * half + i, j]
            row += 1
    return row


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


@compiled
def assemble(
    dt: float,
    q: Vector,
    posture: Vector,
    wrenches: Matrix,
    force_min: Vector,
    target_positions: Matrix,
    target_rotations: Matrix,
    positions: Matrix,
    rotations: Matrix,
    jacobians: Matrix,
    point_jacobians: Matrix,
    static: Vector,
    static_dq: Matrix,
    static_dl: Matrix,
    base_coupling: Matrix,
    supports: Indices,
    contacts: Indices,
    columns: Indices,
    diagonal: Vector,
    wrench_goal: Vector,
    posture_weight: float,
    momentum_weight: float,
    torque_weights: Vector,
    pose_weights: Matrix,
    clamps: Vector,
    force_max: Vector,
    joint_lower: Vector,
    joint_upper: Vector,
    velocity: Vector,
    effort: Vector,
    rates: Vector,
    drifts: Matrix,
    wrench: Vector,
    hessian: Matrix,
    gradient: Vector,
    rows: Matrix,
    lower: Vector,
    upper: Vector,
) -> None:
    """Fill the program of one tick; see `ProgramBuilder`."""
    nv, n = static.shape[0], gradient.shape[0]
    for c in range(contacts.shape[0]):
        for j in range(contacts[c, 2]):
            wrench[contacts[c, 1] - nv + j] = wrenches[contacts[c, 0], j]
    fill_drifts(positions, rotations, target_positions, target_rotations, drifts)
    first_row = fill_equalities(
        dt,
        static,
        static_dq,
        static_dl,
        jacobians,
        point_jacobians,
        drifts,
        contacts,
        supports,
        clamps,
        rows,
        lower[n:],
        upper[n:],
    )
    fill_torque_rows(static_dq, static_dl, columns, contacts, first_row, rows)
    fill_cost(
        dt,
        q,
        posture,
        static,
        jacobians,
        drifts,
        wrench,
        wrench_goal,
        rows,
        first_row,
        columns,
        supports,
        diagonal,
        posture_weight,
        momentum_weight,
        base_coupling,
        torque_weights,
        pose_weights,
        clamps,
        hessian,
        gradient,
    )
    fill_bounds(
        dt,
        q,
        static[6:],
        wrench,
        force_min,
        force_max,
        joint_lower,
        joint_upper,
        velocity,
        effort,
        rates,
        contacts,
        rows,
        first_row,
        lower,
        upper,
    )
