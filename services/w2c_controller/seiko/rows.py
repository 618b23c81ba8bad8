"""Rows of both QPs, compiled: equalities, and the torques that a solution changes.

A joint's torque depends on the joints between base and tips through it, and on the wrenches of the
end effectors beyond it: the layout lists the columns of T that are not zero.
"""

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled
from w2c_controller.seiko.corrections import BIAS_FORCE, BIAS_POSITION, clamped_share

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]


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
