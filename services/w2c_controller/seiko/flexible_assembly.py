"""Assembly of the Controller QP, compiled: what it shares with the Retargeting is in `rows`."""

from typing import Final

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled
from w2c_controller.kinematics.configuration import integrate
from w2c_controller.seiko.corrections import fill_drifts
from w2c_controller.seiko.costs import add_square
from w2c_controller.seiko.rolling import roll
from w2c_controller.seiko.rows import fill_equalities, fill_torque_rows

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]

RATE: Final = 0
OFFSET: Final = 1
"""Where the weights of command rate and command offset stand."""


@compiled
def fill_command_rows(
    q: Vector,
    static: Vector,
    stiffness: Vector,
    command: Vector,
    columns: Indices,
    first_row: int,
    rows: Matrix,
    lag: Vector,
) -> None:
    """Fill D of theta_cmd' = D x + d / dt, and d; the torque rows T_J behind D stand already.

    D = K^-1 (T_J + [0 K 0]),  d = K^-1 (s_J - K (theta_cmd - theta)); d is `lag` (nj,).
    """
    nj = lag.shape[0]
    for i in range(nj):
        yielding = 1.0 / stiffness[i]
        lag[i] = yielding * static[6 + i] - command[i] + q[7 + i]
        row, torque = rows[first_row + i], rows[first_row + nj + i]
        for j in columns[i]:
            if j < 0:
                break
            row[j] = yielding * torque[j]
        row[6 + i] += 1.0


@compiled
def fill_command_bounds(
    dt: float,
    torque: Vector,
    lag: Vector,
    command: Vector,
    offset: Vector,
    offset_limit: float,
    joint_lower: Vector,
    joint_upper: Vector,
    torque_limits: Vector,
    lower: Vector,
    upper: Vector,
) -> None:
    """Fill the limits of commands, then of torques; x = 0 stays inside all of them."""
    nj = lag.shape[0]
    for i in range(nj):
        highest = min(joint_upper[i] - command[i], offset_limit - offset[i])
        lowest = max(joint_lower[i] - command[i], -offset_limit - offset[i])
        upper[i] = max((highest - lag[i]) / dt, 0.0)
        lower[i] = min((lowest - lag[i]) / dt, 0.0)
        upper[nj + i] = max((torque_limits[i] - torque[i]) / dt, 0.0)
        lower[nj + i] = min((-torque_limits[i] - torque[i]) / dt, 0.0)


@compiled
def fill_flexible_cost(
    dt: float,
    offset: Vector,
    lag: Vector,
    effort_rates: Matrix,
    jacobians: Matrix,
    drifts: Matrix,
    contacts: Indices,
    supports: Indices,
    columns: Indices,
    rows: Matrix,
    first_row: int,
    weights: Vector,
    pose_weights: Matrix,
    diagonal: Vector,
    hessian: Matrix,
    gradient: Vector,
) -> None:
    """Fill H (upper triangle) and g; `drifts` (4, 6) lead to the poses of the desired robot."""
    n = gradient.shape[0]
    for i in range(n):
        gradient[i] = 0.0
        for j in range(i, n):
            hessian[i, j] = 0.0
        hessian[i, i] = diagonal[i]
    # Rate and offset after the tick are the same rows of x, so they make one square.
    together = weights[RATE] + weights[OFFSET] * dt * dt
    for i in range(lag.shape[0]):
        pull = weights[RATE] * lag[i] / dt + weights[OFFSET] * dt * (offset[i] + lag[i])
        goal = -pull / together
        add_square(rows[first_row + i], columns[i], together, goal, hessian, gradient)
    for c in range(contacts.shape[0]):
        for j in range(contacts[c, 2]):
            i = contacts[c, 1] + j
            gradient[i] -= diagonal[i] * effort_rates[contacts[c, 0], j]
    for k in range(4):
        for part in range(6):
            weight = pose_weights[k, part // 3]
            if weight != 0.0:
                add_square(
                    jacobians[k, part],
                    supports[k],
                    weight,
                    drifts[k, part] / dt,
                    hessian,
                    gradient,
                )


@compiled
def assemble_flexible(
    dt: float,
    q: Vector,
    offset: Vector,
    command: Vector,
    contact_positions: Matrix,
    contact_rotations: Matrix,
    positions: Matrix,
    rotations: Matrix,
    jacobians: Matrix,
    point_jacobians: Matrix,
    static: Vector,
    static_dq: Matrix,
    static_dl: Matrix,
    desired_positions: Matrix,
    desired_rotations: Matrix,
    effort_rates: Matrix,
    torque_limits: Vector,
    supports: Indices,
    contacts: Indices,
    columns: Indices,
    stiffness: Vector,
    weights: Vector,
    pose_weights: Matrix,
    diagonal: Vector,
    clamps: Vector,
    offset_limit: float,
    joint_lower: Vector,
    joint_upper: Vector,
    drifts: Matrix,
    lag: Vector,
    hessian: Matrix,
    gradient: Vector,
    rows: Matrix,
    lower: Vector,
    upper: Vector,
) -> None:
    """Fill the program of one tick; see `FlexibleProgram`."""
    n, nj = gradient.shape[0], lag.shape[0]
    fill_drifts(positions, rotations, contact_positions, contact_rotations, drifts)
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
    fill_torque_rows(static_dq, static_dl, columns, contacts, first_row + nj, rows)
    fill_command_rows(q, static, stiffness, command, columns, first_row, rows, lag)
    fill_command_bounds(
        dt,
        static[6:],
        lag,
        command,
        offset,
        offset_limit,
        joint_lower,
        joint_upper,
        torque_limits,
        lower[n + first_row :],
        upper[n + first_row :],
    )
    fill_drifts(positions, rotations, desired_positions, desired_rotations, drifts)
    fill_flexible_cost(
        dt,
        offset,
        lag,
        effort_rates,
        jacobians,
        drifts,
        contacts,
        supports,
        columns,
        rows,
        first_row,
        weights,
        pose_weights,
        diagonal,
        hessian,
        gradient,
    )


@compiled
def advance_flexible(
    dt: float,
    x: Vector,
    contacts: Indices,
    columns: Indices,
    rows: Matrix,
    first_row: int,
    lag: Vector,
    offset_limit: float,
    jacobians: Matrix,
    supports: Indices,
    levers: Matrix,
    q: Vector,
    offset: Vector,
    wrenches: Matrix,
    rates: Matrix,
    contact_positions: Matrix,
) -> None:
    """Move posture, offset and wrenches by one tick of a solution, and note its wrench rates.

    Places of contacts move as balls roll, by the kinematics before the tick.
    """
    roll(dt, x, jacobians, supports, levers, contacts, contact_positions)
    for i in range(lag.shape[0]):
        rate = lag[i] / dt
        for j in columns[i]:
            if j < 0:
                break
            rate += rows[first_row + i, j] * x[j]
        offset[i] = min(max(offset[i] + dt * rate, -offset_limit), offset_limit)
    integrate(q, x, dt, q)
    for c in range(contacts.shape[0]):
        for j in range(contacts[c, 2]):
            rate = x[contacts[c, 1] + j]
            rates[contacts[c, 0], j] = rate
            wrenches[contacts[c, 0], j] += dt * rate
