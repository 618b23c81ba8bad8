"""A floating-base tree of revolute joints: its constants, as compiled code takes them.

Body 0 is the base, body k is moved by joint k - 1, whose velocity stands at 5 + k in v.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
import pinocchio as pin

from w2c.errors import ConfigError

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
