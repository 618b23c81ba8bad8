"""How the centroidal momentum couples the base with every velocity, compiled.

With h = A_G v the momentum about the centre of mass (linear, angular), SEIKO's cost w |h|^2 has the
Hessian w A_G' A_G. Its rows of the base are exact here; the products of two joints, w times some
kg^2 m^2 beside the weight of joint velocities, are left out: they would couple every limb with
every other and fill in the factors of the QP.
"""

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]

MASSES = 10
"""Of a subtree: mass, mass times centre (3,), and inertia about the world's origin (xx, yy, zz, xy,
xz, yz)."""


@compiled
def sum_masses(
    parents: Indices,
    masses: Vector,
    centers: Matrix,
    inertias: Matrix,
    rotations: Matrix,
    origins: Matrix,
    sums: Matrix,
) -> None:
    """Fill the mass properties (n, 10) of the subtree of each body, in the world.

    `centers` (n, 3) and `inertias` (n, 3, 3) about them are in the body's frame.
    """
    count = parents.shape[0]
    for k in range(count):
        rotation, total, mass = rotations[k], sums[k], masses[k]
        x, y, z = origins[k, 0], origins[k, 1], origins[k, 2]
        for j in range(3):
            x += rotation[0, j] * centers[k, j]
            y += rotation[1, j] * centers[k, j]
            z += rotation[2, j] * centers[k, j]
        total[0], total[1], total[2], total[3] = mass, mass * x, mass * y, mass * z
        total[4], total[5], total[6] = (
            mass * (y * y + z * z),
            mass * (x * x + z * z),
            mass * (x * x + y * y),
        )
        total[7], total[8], total[9] = -mass * x * y, -mass * x * z, -mass * y * z
        for j in range(3):
            a, b, c = rotation[0, j], rotation[1, j], rotation[2, j]
            # Row j of R I, turned back: I_world = sum_j of column j of R times (I R')_j.
            u = v = w = 0.0
            for m in range(3):
                u += inertias[k, j, m] * rotation[0, m]
                v += inertias[k, j, m] * rotation[1, m]
                w += inertias[k, j, m] * rotation[2, m]
            total[4] += a * u
            total[5] += b * v
            total[6] += c * w
            total[7] += a * v
            total[8] += a * w
            total[9] += b * w
    for i in range(count - 1):
        k = count - 1 - i
        for j in range(MASSES):
            sums[parents[k], j] += sums[k, j]


@compiled
def _momentum_of_turn(
    subtree: Vector, total: Vector, axis: Vector, origin: Vector, momentum: Vector
) -> None:
    """Fill the momentum (6,) about the whole's centre of mass of a subtree that turns."""
    a, b, c = axis[0], axis[1], axis[2]
    x, y, z = origin[0], origin[1], origin[2]
    # The subtree's points move by a x (p - o) = a x p + e.
    d, e, f = y * c - z * b, z * a - x * c, x * b - y * a
    mass, mx, my, mz = subtree[0], subtree[1], subtree[2], subtree[3]
    p0 = b * mz - c * my + mass * d
    p1 = c * mx - a * mz + mass * e
    p2 = a * my - b * mx + mass * f
    l0 = subtree[4] * a + subtree[7] * b + subtree[8] * c + my * f - mz * e
    l1 = subtree[7] * a + subtree[5] * b + subtree[9] * c + mz * d - mx * f
    l2 = subtree[8] * a + subtree[9] * b + subtree[6] * c + mx * e - my * d
    x, y, z = total[1] / total[0], total[2] / total[0], total[3] / total[0]
    momentum[0], momentum[1], momentum[2] = p0, p1, p2
    momentum[3] = l0 - (y * p2 - z * p1)
    momentum[4] = l1 - (z * p0 - x * p2)
    momentum[5] = l2 - (x * p1 - y * p0)


@compiled
def couple_base(
    parents: Indices,
    masses: Vector,
    centers: Matrix,
    inertias: Matrix,
    rotations: Matrix,
    origins: Matrix,
    axes: Matrix,
    sums: Matrix,
    columns: Matrix,
    coupling: Matrix,
) -> None:
    """Fill the rows of the base of A_G' A_G (6, nv); `sums` (n, 10) and `columns` are overwritten.

    `columns` (nv, 6) becomes A_G'.
    """
    sum_masses(parents, masses, centers, inertias, rotations, origins, sums)
    total = sums[0]
    for m in range(3):
        for i in range(3):
            columns[m, i] = total[0] * rotations[0, i, m]
            columns[m, 3 + i] = 0.0
        _momentum_of_turn(total, total, rotations[0, :, m], origins[0], columns[3 + m])
    for k in range(1, parents.shape[0]):
        _momentum_of_turn(sums[k], total, axes[k], origins[k], columns[5 + k])
    for i in range(6):
        for j in range(columns.shape[0]):
            product = 0.0
            for m in range(6):
                product += columns[i, m] * columns[j, m]
            coupling[i, j] = product
