"""Assembly of the Retargeting QP, compiled: only entries that depend on the tick are written."""

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled
from w2c_controller.seiko.bounds import fill_bounds
from w2c_controller.seiko.corrections import fill_drifts
from w2c_controller.seiko.costs import fill_cost
from w2c_controller.seiko.rows import fill_equalities, fill_torque_rows

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]


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
