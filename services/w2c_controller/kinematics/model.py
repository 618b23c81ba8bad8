"""The robot's model: what is constant (`ControlledModel`), what depends on posture (`Kinematics`).

q (nq,) = base position in the world, base quaternion xyzw, joints; v (nv,) = base twist in the
base frame,
linear then angular, joint velocities. Joints are in Pinocchio's order; `joint_indices` leads from
the order of the bus.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
import pinocchio as pin

from w2c.errors import ConfigError
from w2c.geometry import base_from_midfeet, inverse, quaternion_from_rotation
from w2c.messages import RobotDescription
from w2c_controller.kinematics.carried import LOADS, Contacts
from w2c_controller.kinematics.configuration import integrate
from w2c_controller.kinematics.momentum import MASSES
from w2c_controller.kinematics.placement import place
from w2c_controller.kinematics.statics import place_under_load
from w2c_controller.kinematics.tree import Tree

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]

HELD_PREFIXES = ("head_", "gripper_")
"""Joints that the QP does not move: the head looks, a gripper of 1 Nm effort is never feasible."""


@dataclass(frozen=True)
class ControlledModel:
    """A floating-base model of the joints in the QP, with the frames of the four end effectors."""

    model: pin.Model
    frames: tuple[int, int, int, int]
    """Frame ids: left sole, right sole, left hand, right hand."""
    hand_radius: tuple[float, float]
    stiffness: Vector
    """(nj,) [Nm/rad]"""
    effort: Vector
    """(nj,) [Nm]"""
    lower: Vector
    """(nj,) [rad]"""
    upper: Vector
    velocity: Vector
    """(nj,) limit [rad/s]"""
    joint_indices: Indices
    """(nj,) where joint i of the QP stands in vectors of the bus"""
    joint_names: tuple[str, ...]

    @cached_property
    def tree(self) -> Tree:
        """The bodies, for compiled kinematics. Raises ConfigError."""
        return Tree.of(self.model, self.frames)

    @property
    def nv(self) -> int:
        """Number of velocities: 6 of the base and one a joint."""
        return int(self.model.nv)

    @property
    def nj(self) -> int:
        """Number of joints in the QP."""
        return int(self.model.nv) - 6

    def joints_of(self, index: int) -> Indices:
        """Return the rows (in v) of the joints of this end effector's limb, base to tip."""
        joint = self.model.frames[self.frames[index]].parentJoint
        prefix = self.joint_names[joint - 2].rsplit("_", 2)[0]
        names = [i for i, name in enumerate(self.joint_names) if name.startswith(prefix)]
        return np.array(names, dtype=np.intp) + 6

    @property
    def balance_joints(self) -> Indices:
        """Which joints are of legs and trunk: all but those of the arms."""
        arms = [row - 6 for index in (2, 3) for row in self.joints_of(index)]
        return np.array([row for row in range(self.nj) if row not in arms], dtype=np.intp)


def build_model(description: RobotDescription) -> ControlledModel:
    """Return the model of a robot that describes itself. Raises ConfigError."""
    try:
        full = pin.buildModelFromXML(description.urdf, pin.JointModelFreeFlyer())
    except (ValueError, RuntimeError) as error:
        raise ConfigError(
            f"the robot's description is no URDF that Pinocchio reads: {error}"
        ) from error
    positions = {
        joint.name: float(angle)
        for joint, angle in zip(description.joints, description.initial_position, strict=True)
    }
    unknown = [name for name in positions if not full.existJointName(name)]
    if unknown:
        raise ConfigError(f"joints {unknown} are on the bus but not in the robot's URDF")
    moved = {name for name in positions if not name.startswith(HELD_PREFIXES)}
    reference = pin.neutral(full)
    locked = []
    for index in range(2, full.njoints):
        name = full.names[index]
        if name in positions and full.joints[index].nq == 1:
            reference[full.joints[index].idx_q] = positions[name]
        if name not in moved:
            locked.append(index)
    return _describe(pin.buildReducedModel(full, locked, reference), description)


def _describe(model: pin.Model, description: RobotDescription) -> ControlledModel:
    """Put the facts of the description beside the reduced model, in its order of joints."""
    names = tuple(model.names[2:])
    order = {joint.name: i for i, joint in enumerate(description.joints)}
    indices = np.array([order[name] for name in names], dtype=np.intp)
    frames = []
    for frame in (*description.sole_frames, *description.hand_frames):
        if not model.existFrame(frame):
            raise ConfigError(f"frame '{frame}' of the robot's description is not in its URDF")
        frames.append(model.getFrameId(frame))
    left_foot, right_foot, left_hand, right_hand = frames
    return ControlledModel(
        model=model,
        frames=(left_foot, right_foot, left_hand, right_hand),
        hand_radius=description.hand_radius,
        stiffness=np.array([description.joints[i].stiffness for i in indices]),
        effort=np.array([description.joints[i].effort_limit for i in indices]),
        lower=model.lowerPositionLimit[7:].copy(),
        upper=model.upperPositionLimit[7:].copy(),
        velocity=model.velocityLimit[6:].copy(),
        joint_indices=indices,
        joint_names=names,
    )


FeetOnGround = tuple[int, int]
BOTH_FEET: FeetOnGround = (0, 1)
NO_LEVERS: Matrix = np.zeros((4, 3))
"""All contacts touch at the origins of their frames."""
NO_LEVERS.flags.writeable = False


def standing_configuration(
    controlled: ControlledModel,
    joints: Vector,
    data: pin.Data | None = None,
    feet: FeetOnGround = BOTH_FEET,
) -> Vector:
    """Return q (nq,) with the world midway between the soles.

    Args:
        controlled: The robot.
        joints: (nj,) in the model's order [rad].
        data: Pinocchio's, overwritten; None makes its own.
        feet: The feet that stand; on one foot, the same one twice.
    """
    model = controlled.model
    data = model.createData() if data is None else data
    q = pin.neutral(model)
    q[7:] = joints
    pin.framesForwardKinematics(model, data, q)
    left, right = (data.oMf[controlled.frames[k]].homogeneous.copy() for k in feet)
    world_from_base = inverse(base_from_midfeet(left, right))
    q[:3] = world_from_base[:3, 3]
    q[3:7] = quaternion_from_rotation(world_from_base[:3, :3])
    return np.asarray(q, dtype=np.float64)


class Kinematics:
    """Everything the QP needs of one posture under one set of contact wrenches.

    All outputs stand in preallocated arrays, which the next update overwrites in place. Each
    `Kinematics` has arrays of its own, so that two of them may run in two threads.
    """

    def __init__(self, controlled: ControlledModel) -> None:
        self.controlled = controlled
        nv, tree = controlled.nv, controlled.tree
        bodies = tree.parents.size
        self.positions = np.zeros((4, 3))
        """Of the end effectors in the world."""
        self.rotations = np.zeros((4, 3, 3))
        """world_from_effector"""
        self.jacobians = np.zeros((4, 6, nv))
        """Linear then angular, world-aligned, at the frame's origin."""
        self.local_jacobians = np.zeros((2, 6, nv))
        """Of the soles, in the sole frames."""
        self.static = np.zeros(nv)
        """s(q, lambda) = g(q) - sum J^T lambda (nv,): base residual, then joint torques."""
        self.static_dq = np.zeros((nv, nv))
        """T_q = ds/dq (nv, nv), in the tangent space of q."""
        self.static_dl = np.zeros((4, nv, 6))
        """T_l = ds/dlambda of each end effector, as a contact: -J^T in the sole frame of a foot;
        -J^T C, three columns, of the force of a hand in the contact frame C, at its point."""
        self.point_jacobians = np.zeros((2, 3, nv))
        """Of the points of the hands that touch, at the ends of their levers, world-aligned."""
        self.base_coupling = np.zeros((6, nv))
        """Rows of the base of A_G^T A_G: squared centroidal momentum."""
        self._body_rotations = np.zeros((bodies, 3, 3))
        self._body_origins = np.zeros((bodies, 3))
        self._body_axes = np.zeros((bodies, 3))
        self._bodies = (self._body_rotations, self._body_origins, self._body_axes)
        self._frames = (self.positions, self.rotations, self.jacobians, self.local_jacobians)
        self._loads = np.zeros((bodies, LOADS))
        self._work = np.zeros((4, 3))
        self._masses = np.zeros((bodies, MASSES))
        self._momentum = np.zeros((nv, 6))
        self.under_load = (
            *tree.kinematic,
            tree.weights,
            tree.centers,
            *self._bodies,
            *self._frames,
            self._loads,
            self._work,
            self.static,
            self.static_dq,
            self.static_dl,
            self.point_jacobians,
        )
        """Arguments of `place_under_load` behind the posture and its contacts."""
        self.in_motion = (
            tree.masses,
            tree.inertias,
            self._masses,
            self._momentum,
            self.base_coupling,
        )
        """Arguments of `couple_base` that are not among those."""

    def update_frames(self, q: Vector) -> None:
        """Compute placements and Jacobians of the end effectors."""
        tree = self.controlled.tree
        place(q, *tree.kinematic, *self._bodies, *self._frames)

    def update_statics(
        self,
        q: Vector,
        wrenches: Matrix,
        contact_rotations: Matrix,
        enabled: Contacts,
        levers: Matrix = NO_LEVERS,
    ) -> None:
        """Compute what `update_frames` does, s, T_q, T_l and the Jacobians of touching points.

        Args:
            q: (nq,)
            wrenches: (4, 6) feet: force, torque in the sole frame; hands: force in theirs, zeros.
            contact_rotations: (4, 3, 3) world_from_contact, of the hands.
            enabled: Which contacts exist.
            levers: (4, 3) of the hands: from the origin of the frame to the point that touches,
                in the world [m]; constant there, as of a ball on a plane.
        """
        place_under_load(
            q,
            wrenches,
            contact_rotations,
            enabled,
            levers,
            *self.under_load,
        )

    def joint_placement(self, joint: int) -> tuple[Matrix, Vector]:
        """Return rotation (3, 3) and position (3,) of a joint's body in the world: views.

        Args:
            joint: Pinocchio's index; 1 is the base.
        """
        return self._body_rotations[joint - 1], self._body_origins[joint - 1]

    def integrate(self, q: Vector, increment: Vector) -> Vector:
        """Return q (+) increment (nv,)."""
        out = np.empty_like(q)
        integrate(q, increment, 1.0, out)
        return out

    def center_of_mass(self, q: Vector) -> Vector:
        """Return the centre of mass (3,) in the world."""
        return np.array(
            pin.centerOfMass(self.controlled.model, self.controlled.model.createData(), q)
        )
