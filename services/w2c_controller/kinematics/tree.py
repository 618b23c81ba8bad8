"""A floating-base tree of revolute joints: its constants, and its kinematics, compiled.

Body 0 is the base, body k is moved by joint k - 1, whose velocity stands at 5 + k in v. Only what
depends on the posture is computed, and only the columns of joints between base and end effector:
the others are zero for ever. Tests compare all of it with Pinocchio.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
import pinocchio as pin

from w2c.errors import ConfigError
from w2c_controller.compiled import compiled

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]


@dataclass(frozen=True)
class Tree:
    """What is constant of the robot's bodies; (n,) runs over bodies, parents before children."""

    parents: Indices
    """(n,) -1 for the base"""
    rotations: Matrix
    """(n, 3, 3) parent_from_joint at angle 0"""
    origins: Matrix
    """(n, 3) of the joint in its parent's frame [m]"""
    axes: Matrix
    """(n, 3) of the joint, in its own frame"""
    masses: Vector
    """(n,) [kg]"""
    weights: Vector
    """(n,) force of gravity on the body, up [N]: negative"""
    centers: Matrix
    """(n, 3) of mass, in the body's frame [m]"""
    inertias: Matrix
    """(n, 3, 3) about the centre of mass, in the body's frame [kg m^2]"""
    effector_bodies: Indices
    """(4,) that carry the end effectors"""
    effector_rotations: Matrix
    """(4, 3, 3) body_from_effector"""
    effector_origins: Matrix
    """(4, 3) in the body's frame [m]"""
    supports: Indices
    """(4, nv) columns of v that move each end effector, base first, then -1"""

    @cached_property
    def kinematic(self) -> tuple[Indices, Matrix, Matrix, Matrix, Indices, Matrix, Matrix, Indices]:
        """The arguments of `place`, between the posture and the outputs."""
        return (
            self.parents,
            self.rotations,
            self.origins,
            self.axes,
            self.effector_bodies,
            self.effector_rotations,
            self.effector_origins,
            self.supports,
        )

    @classmethod
    def of(cls, model: pin.Model, frames: tuple[int, int, int, int]) -> "Tree":
        """Read the tree of a model. Raises ConfigError for joints that are not revolute."""
        bodies = model.njoints - 1
        placements = [model.jointPlacements[k + 1] for k in range(bodies)]
        inertias = [model.inertias[k + 1] for k in range(bodies)]
        effectors = [model.frames[frame] for frame in frames]
        supports = np.full((4, model.nv), -1, dtype=np.intp)
        for k, effector in enumerate(effectors):
            moving = [joint for joint in model.supports[effector.parentJoint] if joint > 1]
            columns = [*range(6), *(model.joints[joint].idx_v for joint in moving)]
            supports[k, : len(columns)] = columns
        return cls(
            parents=np.array([model.parents[k + 1] - 1 for k in range(bodies)], dtype=np.intp),
            rotations=np.array([placement.rotation for placement in placements]),
            origins=np.array([placement.translation for placement in placements]),
            axes=np.array([np.zeros(3), *(_axis(model, k + 1) for k in range(1, bodies))]),
            masses=np.array([inertia.mass for inertia in inertias]),
            weights=np.array([inertia.mass * model.gravity.linear[2] for inertia in inertias]),
            centers=np.array([inertia.lever for inertia in inertias]),
            inertias=np.array([inertia.inertia for inertia in inertias]),
            effector_bodies=np.array([frame.parentJoint - 1 for frame in effectors], dtype=np.intp),
            effector_rotations=np.array([frame.placement.rotation for frame in effectors]),
            effector_origins=np.array([frame.placement.translation for frame in effectors]),
            supports=supports,
        )


def _axis(model: pin.Model, joint: int) -> Vector:
    """Return the axis (3,) of a revolute joint in its own frame."""
    data = model.createData()
    pin.computeJointJacobians(model, data, pin.neutral(model))
    velocity = pin.getJointJacobian(model, data, joint, pin.ReferenceFrame.LOCAL)
    twist = velocity[:, model.joints[joint].idx_v]
    moves = model.joints[joint].nv == 1 and np.abs(twist[:3]).max() < 1e-12
    if not moves or abs(np.linalg.norm(twist[3:]) - 1.0) > 1e-12:
        raise ConfigError(
            f"joint '{model.names[joint]}' is a {model.joints[joint].shortname()}: the controller "
            "moves revolute joints only; lock it in the URDF"
        )
    return np.array(twist[3:])


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


@compiled
def integrate(q: Vector, velocity: Vector, dt: float, out: Vector) -> None:
    """Fill q (+) dt v (nq,): the base moves along its own constant twist, joints add up.

    Args:
        q: (nq,)
        velocity: (nv,)
        dt: [s]
        out: (nq,) may be q itself.
    """
    a, b, c = dt * velocity[3], dt * velocity[4], dt * velocity[5]
    d, e, f = dt * velocity[0], dt * velocity[1], dt * velocity[2]
    square = a * a + b * b + c * c
    angle = math.sqrt(square)
    if angle > 1e-4:
        sine, versine = math.sin(angle) / angle, (1.0 - math.cos(angle)) / square
        rest, half = (1.0 - sine) / square, math.sin(0.5 * angle) / angle
    else:
        sine, versine = 1.0 - square / 6.0, 0.5 - square / 24.0
        rest, half = 1.0 / 6.0 - square / 120.0, 0.5 - square / 48.0
    along = rest * (a * d + b * e + c * f)
    u = sine * d + versine * (b * f - c * e) + along * a
    v = sine * e + versine * (c * d - a * f) + along * b
    w = sine * f + versine * (a * e - b * d) + along * c
    x, y, z, s = q[3], q[4], q[5], q[6]
    # p + R t with R of the unit quaternion (r, s): t + 2 s (r x t) + 2 r x (r x t).
    g, h, k = y * w - z * v, z * u - x * w, x * v - y * u
    out[0] = q[0] + u + 2.0 * (s * g + y * k - z * h)
    out[1] = q[1] + v + 2.0 * (s * h + z * g - x * k)
    out[2] = q[2] + w + 2.0 * (s * k + x * h - y * g)
    a, b, c, t = half * a, half * b, half * c, math.cos(0.5 * angle)
    out[3] = s * a + x * t + y * c - z * b
    out[4] = s * b + y * t + z * a - x * c
    out[5] = s * c + z * t + x * b - y * a
    out[6] = s * t - x * a - y * b - z * c
    length = math.sqrt(out[3] ** 2 + out[4] ** 2 + out[5] ** 2 + out[6] ** 2)
    for i in range(3, 7):
        out[i] /= length
    for i in range(7, q.shape[0]):
        out[i] = q[i] + dt * velocity[i - 1]
