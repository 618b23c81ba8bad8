"""Where the bodies and end effectors of a tree are, and how they move, compiled.

Only what depends on the posture is computed, and only the columns of joints between base and end
effector: the others are zero for ever. Tests compare all of it with Pinocchio.
"""

import math

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]


@compiled
def place(
    q: Vector,
    parents: Indices,
    joint_rotations: Matrix,
    joint_origins: Matrix,
    joint_axes: Matrix,
    effector_bodies: Indices,
    effector_rotations: Matrix,
    effector_origins: Matrix,
    supports: Indices,
    body_rotations: Matrix,
    body_origins: Matrix,
    body_axes: Matrix,
    positions: Matrix,
    rotations: Matrix,
    jacobians: Matrix,
    local_jacobians: Matrix,
) -> None:
    """Fill the placements of all bodies, and those and the Jacobians of the end effectors."""
    place_bodies(
        q,
        parents,
        joint_rotations,
        joint_origins,
        joint_axes,
        body_rotations,
        body_origins,
        body_axes,
    )
    place_effectors(
        parents,
        effector_bodies,
        effector_rotations,
        effector_origins,
        supports,
        body_rotations,
        body_origins,
        body_axes,
        positions,
        rotations,
        jacobians,
        local_jacobians,
    )


@compiled
def place_bodies(
    q: Vector,
    parents: Indices,
    joint_rotations: Matrix,
    joint_origins: Matrix,
    joint_axes: Matrix,
    rotations: Matrix,
    origins: Matrix,
    axes: Matrix,
) -> None:
    """Fill world_from_body (n, 3, 3), origins (n, 3) and joint axes (n, 3) in the world."""
    x, y, z, w = q[3], q[4], q[5], q[6]
    base = rotations[0]
    base[0, 0], base[0, 1], base[0, 2] = (
        1 - 2 * (y * y + z * z),
        2 * (x * y - z * w),
        2 * (x * z + y * w),
    )
    base[1, 0], base[1, 1], base[1, 2] = (
        2 * (x * y + z * w),
        1 - 2 * (x * x + z * z),
        2 * (y * z - x * w),
    )
    base[2, 0], base[2, 1], base[2, 2] = (
        2 * (x * z - y * w),
        2 * (y * z + x * w),
        1 - 2 * (x * x + y * y),
    )
    for i in range(3):
        origins[0, i] = q[i]
    for k in range(1, parents.shape[0]):
        up, turned = rotations[parents[k]], joint_rotations[k]
        a, b, c = joint_axes[k, 0], joint_axes[k, 1], joint_axes[k, 2]
        sine, cosine = math.sin(q[6 + k]), math.cos(q[6 + k])
        rest = 1.0 - cosine
        for i in range(3):
            origins[k, i] = origins[parents[k], i]
            for j in range(3):
                origins[k, i] += up[i, j] * joint_origins[k, j]
            # Row i of parent_from_joint in the world, then Rodrigues' rotation about (a, b, c).
            u = up[i, 0] * turned[0, 0] + up[i, 1] * turned[1, 0] + up[i, 2] * turned[2, 0]
            v = up[i, 0] * turned[0, 1] + up[i, 1] * turned[1, 1] + up[i, 2] * turned[2, 1]
            t = up[i, 0] * turned[0, 2] + up[i, 1] * turned[1, 2] + up[i, 2] * turned[2, 2]
            along = a * u + b * v + c * t
            axes[k, i] = along
            rotations[k, i, 0] = cosine * u + rest * along * a + sine * (c * v - b * t)
            rotations[k, i, 1] = cosine * v + rest * along * b + sine * (a * t - c * u)
            rotations[k, i, 2] = cosine * t + rest * along * c + sine * (b * u - a * v)


@compiled
def place_effectors(
    parents: Indices,
    bodies: Indices,
    effector_rotations: Matrix,
    effector_origins: Matrix,
    supports: Indices,
    rotations: Matrix,
    origins: Matrix,
    axes: Matrix,
    positions: Matrix,
    world_from_effector: Matrix,
    jacobians: Matrix,
    local_jacobians: Matrix,
) -> None:
    """Fill positions (4, 3), rotations (4, 3, 3) and Jacobians (4, 6, nv) of the end effectors."""
    for e in range(4):
        body = rotations[bodies[e]]
        for i in range(3):
            positions[e, i] = origins[bodies[e], i]
            for j in range(3):
                positions[e, i] += body[i, j] * effector_origins[e, j]
                world_from_effector[e, i, j] = 0.0
                for m in range(3):
                    world_from_effector[e, i, j] += body[i, m] * effector_rotations[e, m, j]
        jacobian = jacobians[e]
        base = rotations[0]
        for m in range(3):
            for i in range(3):
                jacobian[i, m] = base[i, m]
            _turning(base[0, m], base[1, m], base[2, m], origins[0], positions[e], jacobian, 3 + m)
        k = bodies[e]
        while k > 0:
            _turning(axes[k, 0], axes[k, 1], axes[k, 2], origins[k], positions[e], jacobian, 5 + k)
            k = parents[k]
        if e < 2:
            _turn_rows(world_from_effector[e], jacobian, supports[e], local_jacobians[e])


@compiled
def _turning(
    a: float, b: float, c: float, origin: Vector, point: Vector, jacobian: Matrix, column: int
) -> None:
    """Fill the column of a turn about (a, b, c) through an origin: how a point moves, and turns."""
    x, y, z = point[0] - origin[0], point[1] - origin[1], point[2] - origin[2]
    jacobian[0, column] = b * z - c * y
    jacobian[1, column] = c * x - a * z
    jacobian[2, column] = a * y - b * x
    jacobian[3, column] = a
    jacobian[4, column] = b
    jacobian[5, column] = c


@compiled
def _turn_rows(rotation: Matrix, jacobian: Matrix, columns: Indices, local: Matrix) -> None:
    """Fill R' J of both halves of a Jacobian (6, nv)."""
    for j in columns:
        if j < 0:
            break
        for half in (0, 3):
            u, v, w = jacobian[half, j], jacobian[half + 1, j], jacobian[half + 2, j]
            for i in range(3):
                local[half + i, j] = rotation[0, i] * u + rotation[1, i] * v + rotation[2, i] * w
