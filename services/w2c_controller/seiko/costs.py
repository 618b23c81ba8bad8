"""Costs of the Retargeting QP, compiled, and what the Controller QP shares of them.

A row of torques or of a Jacobian has about fifteen entries other than zero: costs are summed over
those alone, into the upper triangle of H.
"""

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled
from w2c_controller.seiko.corrections import POSITION, POSTURE, clamped_share

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]


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
