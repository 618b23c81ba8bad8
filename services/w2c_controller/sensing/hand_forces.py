"""Forces on the hands in the world, compiled: one from a wrist sensor, one from joint torques.

The ball-ended right hand has no sensor. Its force is the least-squares solution of

    J^T F = s(q) - tau

over the joints of its arm (quasi-static; four equations for three unknowns), with the torques s
that gravity alone would need. Everything is in the frame of the base, until the end.
"""

import math
from typing import Final

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]

DAMPING: Final = 1e-6
"""Keeps the equations solvable with a stretched arm [m^2]."""


@compiled
def level_feet(left: Matrix, right: Matrix, world_from_base: Matrix) -> None:
    """Fill the rotation with which two soles (base_from_sole) are level, and ahead, on average."""
    length = 0.0
    for i in range(3):
        world_from_base[2, i] = left[i, 2] + right[i, 2]
        length += world_from_base[2, i] ** 2
    length = math.sqrt(length)
    along = 0.0
    for i in range(3):
        world_from_base[2, i] /= length
        along += (left[i, 0] + right[i, 0]) * world_from_base[2, i]
    length = 0.0
    for i in range(3):
        world_from_base[0, i] = left[i, 0] + right[i, 0] - along * world_from_base[2, i]
        length += world_from_base[0, i] ** 2
    length = math.sqrt(length)
    for i in range(3):
        world_from_base[0, i] /= length
    x, z = world_from_base[0], world_from_base[2]
    world_from_base[1, 0] = z[1] * x[2] - z[2] * x[1]
    world_from_base[1, 1] = z[2] * x[0] - z[0] * x[2]
    world_from_base[1, 2] = z[0] * x[1] - z[1] * x[0]


@compiled
def _dot(a: Vector, b: Vector) -> float:
    return float(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


@compiled
def gravity_torque(
    joint: int,
    last: int,
    up: Vector,
    axes: Matrix,
    origins: Matrix,
    rotations: Matrix,
    centers: Matrix,
    weights: Vector,
) -> float:
    """Return the torque that holds the bodies of a chain, from one joint to its end [Nm].

    Args:
        joint: Body that the joint moves.
        last: Last body of the chain; those between follow each other.
        up: (3,) unit.
        axes: (n, 3) of the joints.
        origins: (n, 3) of the joints.
        rotations: (n, 3, 3) of the bodies.
        centers: (n, 3) of mass, in the bodies.
        weights: (n,) forces along `up`: negative.
    """
    total = 0.0
    for body in range(joint, last + 1):
        c = centers[body]
        x = origins[body, 0] - origins[joint, 0] + _dot(rotations[body, 0], c)
        y = origins[body, 1] - origins[joint, 1] + _dot(rotations[body, 1], c)
        z = origins[body, 2] - origins[joint, 2] + _dot(rotations[body, 2], c)
        moment = (
            axes[joint, 0] * (y * up[2] - z * up[1])
            + axes[joint, 1] * (z * up[0] - x * up[2])
            + axes[joint, 2] * (x * up[1] - y * up[0])
        )
        total -= weights[body] * moment
    return total


@compiled
def least_squares_force(jacobian: Matrix, columns: Indices, residual: Vector, out: Vector) -> None:
    """Fill the force (3,) whose J^T F is closest to the residual (n,); J has three rows."""
    a = d = f = DAMPING
    b = c = e = 0.0
    x = y = z = 0.0
    for n in range(columns.shape[0]):
        u, v, w = jacobian[0, columns[n]], jacobian[1, columns[n]], jacobian[2, columns[n]]
        a += u * u
        b += u * v
        c += u * w
        d += v * v
        e += v * w
        f += w * w
        x += u * residual[n]
        y += v * residual[n]
        z += w * residual[n]
    # The symmetric matrix [a b c; b d e; c e f], inverted by its cofactors.
    aa, bb, cc = d * f - e * e, c * e - b * f, b * e - c * d
    dd, ee, ff = a * f - c * c, b * c - a * e, a * d - b * b
    determinant = a * aa + b * bb + c * cc
    out[0] = (aa * x + bb * y + cc * z) / determinant
    out[1] = (bb * x + dd * y + ee * z) / determinant
    out[2] = (cc * x + ee * y + ff * z) / determinant


@compiled
def feel_hands(
    left_sole: Matrix,
    right_sole: Matrix,
    left_hand: Matrix,
    wrist_force: Vector,
    arm: Indices,
    torque: Vector,
    jacobian: Matrix,
    axes: Matrix,
    origins: Matrix,
    rotations: Matrix,
    centers: Matrix,
    weights: Vector,
    work: Matrix,
    out: Vector,
) -> None:
    """Fill the forces on both hands (6,) in the world [N].

    Args:
        left_sole: (3, 3) base_from_sole, of the feet that stand.
        right_sole: (3, 3)
        left_hand: (3, 3) base_from_hand.
        wrist_force: (3,) in the hand's frame.
        arm: (n,) columns in v of the right arm's joints, which follow each other.
        torque: (nj,) measured.
        jacobian: (6, nv) of the right hand.
        axes: Of all bodies, as the others that `gravity_torque` takes.
        origins: See there.
        rotations: See there.
        centers: See there.
        weights: See there.
        work: (5, n) overwritten, n at least 3.
        out: (6,) left, right.
    """
    world_from_base, residual, force = work[:3, :3], work[3], work[4, :3]
    level_feet(left_sole, right_sole, world_from_base)
    last = arm[-1] - 5
    for n in range(arm.shape[0]):
        joint = arm[n] - 5
        residual[n] = (
            gravity_torque(
                joint, last, world_from_base[2], axes, origins, rotations, centers, weights
            )
            - torque[arm[n] - 6]
        )
    least_squares_force(jacobian, arm, residual, force)
    for i in range(3):
        out[i] = out[3 + i] = 0.0
        for j in range(3):
            out[3 + i] += world_from_base[i, j] * force[j]
            turned = 0.0
            for k in range(3):
                turned += left_hand[j, k] * wrist_force[k]
            out[i] += world_from_base[i, j] * turned
