"""Statics of the tree and their derivatives, compiled.

Everything follows from sums over the subtree of each body k, with the world axis a_k of its joint
and the origin o_k: F, the forces that are constant in the world (gravity, hands), W = sum x f' over
the points x where they act, force and moment of those that turn with their body (soles), and the
moments that are constant in the world: of a hand's force, which acts at a lever from its centre.

The static torque of joint i, moment about its axis, is s_i = -a_i . (sum (x - o_i) x f). Turning
joint j moves the points of its subtree, and turns a_i, o_i and the soles' wrenches where they are
in it. With V_k = (tr(W_k) - W_k) a_k about o_k this gives

    ds_i/dq_j = a_j . V_i                                         j above i
    ds_i/dq_j = a_i . (V_j - a_j x n_j - (o_j - o_i) x (a_j x f_j))   j below i, or i itself

for the wrench (f_j, n_j) about o_j of the soles in the subtree of j. A constant moment m_i is of no
account where a joint below moves it, and turns with no joint above: V_i - a_i x m_i in the first
line alone. Tests compare all of it with Pinocchio and with finite differences.
"""

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled
from w2c_controller.kinematics.carried import (
    FORCE,
    MOMENT,
    SOLE_FORCE,
    SOLE_MOMENT,
    Contacts,
    sum_loads,
)
from w2c_controller.kinematics.placement import place

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]


@compiled
def _about(
    load: Vector, origin: Vector, a: float, b: float, c: float, moment: Vector, sole: Vector
) -> tuple[float, float, float]:
    """Return V of an axis (a, b, c) through an origin; fill the moments (3,) of a subtree about it.

    V is without the constant moments.

    Args:
        load: (21,) of the subtree.
        origin: (3,)
        a: Of the axis.
        b: Of the axis.
        c: Of the axis.
        moment: (3,) out: of all forces.
        sole: (3,) out: of the soles' wrenches alone.
    """
    x, y, z = origin[0], origin[1], origin[2]
    f0, f1, f2 = load[FORCE], load[FORCE + 1], load[FORCE + 2]
    w00, w01, w02 = load[3] - x * f0, load[4] - x * f1, load[5] - x * f2
    w10, w11, w12 = load[6] - y * f0, load[7] - y * f1, load[8] - y * f2
    w20, w21, w22 = load[9] - z * f0, load[10] - z * f1, load[11] - z * f2
    g0, g1, g2 = load[SOLE_FORCE], load[SOLE_FORCE + 1], load[SOLE_FORCE + 2]
    sole[0] = load[SOLE_MOMENT] - (y * g2 - z * g1)
    sole[1] = load[SOLE_MOMENT + 1] - (z * g0 - x * g2)
    sole[2] = load[SOLE_MOMENT + 2] - (x * g1 - y * g0)
    moment[0] = sole[0] + w12 - w21 + load[MOMENT]
    moment[1] = sole[1] + w20 - w02 + load[MOMENT + 1]
    moment[2] = sole[2] + w01 - w10 + load[MOMENT + 2]
    return (
        (w11 + w22) * a - w01 * b - w02 * c,
        (w00 + w22) * b - w10 * a - w12 * c,
        (w00 + w11) * c - w20 * a - w21 * b,
    )


@compiled
def _without_turning(
    v0: float, v1: float, v2: float, a: float, b: float, c: float, load: Vector
) -> tuple[float, float, float]:
    """Return V - a x m of an axis (a, b, c) and of the constant moments m of a subtree."""
    m0, m1, m2 = load[MOMENT], load[MOMENT + 1], load[MOMENT + 2]
    return v0 - (b * m2 - c * m1), v1 - (c * m0 - a * m2), v2 - (a * m1 - b * m0)


@compiled
def fill_statics(
    parents: Indices,
    rotations: Matrix,
    origins: Matrix,
    axes: Matrix,
    loads: Matrix,
    work: Matrix,
    static: Vector,
    static_dq: Matrix,
) -> None:
    """Fill s (nv,) and ds/dq (nv, nv) of the loads; `work` (4, 3) is overwritten."""
    moment, sole, turned, lever = work[0], work[1], work[2], work[3]
    base, load, origin = rotations[0], loads[0], origins[0]
    for m in range(3):
        a, b, c = base[0, m], base[1, m], base[2, m]
        v0, v1, v2 = _about(load, origin, a, b, c, moment, sole)
        v0, v1, v2 = _without_turning(v0, v1, v2, a, b, c, load)
        static[m] = -(
            a * (load[0] + load[SOLE_FORCE])
            + b * (load[1] + load[SOLE_FORCE + 1])
            + c * (load[2] + load[SOLE_FORCE + 2])
        )
        static[3 + m] = -(a * moment[0] + b * moment[1] + c * moment[2])
        for n in range(3):
            d, e, f = base[0, n], base[1, n], base[2, n]
            static_dq[3 + m, 3 + n] = d * v0 + e * v1 + f * v2
            static_dq[m, 3 + n] = (
                a * (e * load[2] - f * load[1])
                + b * (f * load[0] - d * load[2])
                + c * (d * load[1] - e * load[0])
            )
    for j in range(1, parents.shape[0]):
        a, b, c = axes[j, 0], axes[j, 1], axes[j, 2]
        load, origin = loads[j], origins[j]
        v0, v1, v2 = _about(load, origin, a, b, c, moment, sole)
        static[5 + j] = -(a * moment[0] + b * moment[1] + c * moment[2])
        # How the soles' wrench turns with the joint: its force, and its moment about the origin.
        g0, g1, g2 = load[SOLE_FORCE], load[SOLE_FORCE + 1], load[SOLE_FORCE + 2]
        turned[0], turned[1], turned[2] = b * g2 - c * g1, c * g0 - a * g2, a * g1 - b * g0
        u0 = v0 - (b * sole[2] - c * sole[1])
        u1 = v1 - (c * sole[0] - a * sole[2])
        u2 = v2 - (a * sole[1] - b * sole[0])
        static_dq[5 + j, 5 + j] = a * u0 + b * u1 + c * u2
        v0, v1, v2 = _without_turning(v0, v1, v2, a, b, c, load)
        i = j
        while i > 0:
            i = parents[i]
            for n in range(3):
                lever[n] = origin[n] - origins[i, n]
            w0 = u0 - (lever[1] * turned[2] - lever[2] * turned[1])
            w1 = u1 - (lever[2] * turned[0] - lever[0] * turned[2])
            w2 = u2 - (lever[0] * turned[1] - lever[1] * turned[0])
            if i > 0:
                d, e, f = axes[i, 0], axes[i, 1], axes[i, 2]
                static_dq[5 + i, 5 + j] = d * w0 + e * w1 + f * w2
                static_dq[5 + j, 5 + i] = d * v0 + e * v1 + f * v2
                continue
            for m in range(3):
                d, e, f = base[0, m], base[1, m], base[2, m]
                static_dq[m, 5 + j] = -(d * turned[0] + e * turned[1] + f * turned[2])
                static_dq[3 + m, 5 + j] = d * w0 + e * w1 + f * w2
                static_dq[5 + j, 3 + m] = d * v0 + e * v1 + f * v2


@compiled
def fill_static_dl(
    supports: Indices,
    jacobians: Matrix,
    local_jacobians: Matrix,
    contact_rotations: Matrix,
    levers: Matrix,
    point_jacobians: Matrix,
    static_dl: Matrix,
) -> None:
    """Fill ds/dlambda (4, nv, 6): -J' in the sole frame; of a hand's force -J' C, three columns.

    J of a hand is that of the point of its body at the end of its lever, J_p - [lever]x J_w: it
    fills `point_jacobians` (2, 3, nv).
    """
    for e in range(4):
        for j in supports[e]:
            if j < 0:
                break
            if e < 2:
                for i in range(6):
                    static_dl[e, j, i] = -local_jacobians[e, i, j]
                continue
            a, b, c = jacobians[e, 3, j], jacobians[e, 4, j], jacobians[e, 5, j]
            x, y, z = levers[e, 0], levers[e, 1], levers[e, 2]
            u = jacobians[e, 0, j] + (b * z - c * y)
            v = jacobians[e, 1, j] + (c * x - a * z)
            w = jacobians[e, 2, j] + (a * y - b * x)
            point = point_jacobians[e - 2]
            point[0, j], point[1, j], point[2, j] = u, v, w
            frame = contact_rotations[e]
            for i in range(3):
                static_dl[e, j, i] = -(frame[0, i] * u + frame[1, i] * v + frame[2, i] * w)


@compiled
def place_under_load(
    q: Vector,
    wrenches: Matrix,
    contact_rotations: Matrix,
    enabled: Contacts,
    levers: Matrix,
    parents: Indices,
    joint_rotations: Matrix,
    joint_origins: Matrix,
    joint_axes: Matrix,
    effector_bodies: Indices,
    effector_rotations: Matrix,
    effector_origins: Matrix,
    supports: Indices,
    weights: Vector,
    centers: Matrix,
    body_rotations: Matrix,
    body_origins: Matrix,
    body_axes: Matrix,
    positions: Matrix,
    rotations: Matrix,
    jacobians: Matrix,
    local_jacobians: Matrix,
    loads: Matrix,
    work: Matrix,
    static: Vector,
    static_dq: Matrix,
    static_dl: Matrix,
    point_jacobians: Matrix,
) -> None:
    """Fill kinematics and statics of a posture; see `Kinematics.update_statics`."""
    place(
        q,
        parents,
        joint_rotations,
        joint_origins,
        joint_axes,
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
    sum_loads(
        parents,
        weights,
        centers,
        effector_bodies,
        body_rotations,
        body_origins,
        positions,
        rotations,
        wrenches,
        contact_rotations,
        levers,
        enabled,
        loads,
    )
    fill_statics(parents, body_rotations, body_origins, body_axes, loads, work, static, static_dq)
    fill_static_dl(
        supports, jacobians, local_jacobians, contact_rotations, levers, point_jacobians, static_dl
    )
