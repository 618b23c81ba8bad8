"""Loads on the end effectors, and where they are, from what the robot measures.

Feet and left wrist have force-torque sensors. The force on the ball-ended right hand follows from
the torques of its arm. The base, which nothing measures, is turned so that the feet that stand are
level.
"""

import math
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from w2c.messages import RobotState
from w2c_controller.compiled import compiled
from w2c_controller.kinematics.model import BOTH_FEET, ControlledModel, FeetOnGround
from w2c_controller.kinematics.placement import place
from w2c_controller.motion.filters import low_pass_gain
from w2c_controller.parameters import FEET, LEFT_HAND, RIGHT_HAND
from w2c_controller.sensing.hand_forces import feel_hands

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]

FORCE_CUTOFF_HZ = 10.0


@dataclass(frozen=True)
class Measured:
    """Forces that the environment exerts, filtered, and where the end effectors are.

    NaN where a sensor reads NaN.
    """

    feet: Matrix
    """(2, 6) force, torque in the sole frames, left, right [N, Nm]"""
    hands: Matrix
    """(2, 3) in the world, left, right [N]"""
    torque: Vector = field(default_factory=lambda: np.zeros(0))
    """(nj,) of the joints in the model's order [Nm]"""
    positions: Matrix = field(default_factory=lambda: np.zeros((4, 3)))
    """(4, 3) of the end effectors by the measured joint angles, in the frame of the base [m]:
    nothing measures where that is"""
    rotations: Matrix = field(default_factory=lambda: np.tile(np.eye(3), (4, 1, 1)))
    """(4, 3, 3) base_from_effector"""

    def force(self, effector: int) -> Vector:
        """Return the force (3,) on an end effector: on a foot in its sole frame [N]."""
        return np.asarray(self.feet[effector, :3] if effector in FEET else self.hands[effector - 2])


class LoadEstimator:
    """Keeps the filters of the measured loads."""

    def __init__(self, controlled: ControlledModel, dt: float) -> None:
        nv, tree = controlled.nv, controlled.tree
        bodies = tree.parents.size
        self._joint_indices = controlled.joint_indices
        self._arm = controlled.joints_of(RIGHT_HAND)
        self._kinematic = tree.kinematic
        # Copies: what hangs on a hand becomes part of the model, and is still to be measured.
        self._weights, self._centers = tree.weights.copy(), tree.centers.copy()
        self._q = np.zeros(controlled.model.nq)
        self._q[6] = 1.0
        self._bodies = (np.zeros((bodies, 3, 3)), np.zeros((bodies, 3)), np.zeros((bodies, 3)))
        self._positions, self._rotations = np.zeros((4, 3)), np.zeros((4, 3, 3))
        self._jacobians = (np.zeros((4, 6, nv)), np.zeros((2, 6, nv)))
        self._work = np.zeros((5, max(self._arm.size, 3)))
        self._alpha = low_pass_gain(FORCE_CUTOFF_HZ, dt)
        self._soles = np.zeros((2, 6))
        self._filtered = np.full(18 + controlled.nj, np.nan)
        """Wrenches of the soles, forces on the hands, torques"""
        self._raw = self._filtered.copy()

    def update(self, state: RobotState, feet_on_ground: FeetOnGround = BOTH_FEET) -> Measured:
        """Return the loads of one state; NaN where a sensor says NaN."""
        joints, torque = state.position[self._joint_indices], state.torque[self._joint_indices]
        self._soles[:] = state.sole_wrenches
        known = estimate_loads(
            joints,
            torque,
            self._soles,
            state.left_wrist_wrench,
            feet_on_ground,
            self._q,
            *self._kinematic,
            *self._bodies,
            self._positions,
            self._rotations,
            *self._jacobians,
            self._arm,
            self._centers,
            self._weights,
            self._work,
            self._alpha,
            self._raw,
            self._filtered,
        )
        filtered = self._filtered.copy()
        return Measured(
            feet=filtered[:12].reshape(2, 6),
            hands=filtered[12:18].reshape(2, 3),
            torque=filtered[18:],
            positions=self._positions.copy() if known else np.full((4, 3), np.nan),
            rotations=self._rotations.copy() if known else np.full((4, 3, 3), np.nan),
        )


@compiled
def estimate_loads(
    joints: Vector,
    torque: Vector,
    soles: Matrix,
    wrist: Vector,
    feet: tuple[int, int],
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
    origins: Matrix,
    axes: Matrix,
    positions: Matrix,
    rotations: Matrix,
    jacobians: Matrix,
    local_jacobians: Matrix,
    arm: Indices,
    centers: Matrix,
    weights: Vector,
    work: Matrix,
    alpha: float,
    raw: Vector,
    filtered: Vector,
) -> bool:
    """Fill frames in the base's, and the loads, raw and filtered; see `LoadEstimator`.

    Returns:
        Whether all joint angles are finite; frames and forces on hands are not known otherwise.
    """
    known = True
    for i in range(joints.shape[0]):
        known = known and math.isfinite(joints[i])
        q[7 + i] = joints[i]
        raw[18 + i] = torque[i]
    for i in range(12):
        raw[i] = soles[i // 6, i % 6]
    if known:
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
            origins,
            axes,
            positions,
            rotations,
            jacobians,
            local_jacobians,
        )
        feel_hands(
            rotations[feet[0]],
            rotations[feet[1]],
            rotations[LEFT_HAND],
            wrist,
            arm,
            torque,
            jacobians[RIGHT_HAND],
            axes,
            origins,
            body_rotations,
            centers,
            weights,
            work,
            raw[12:18],
        )
    else:
        for i in range(12, 18):
            raw[i] = math.nan
    _low_pass(alpha, raw, filtered)
    return known


@compiled
def _low_pass(alpha: float, value: Vector, filtered: Vector) -> None:
    """Filter each component; one that is not finite passes, and starts its filter again."""
    for i in range(value.shape[0]):
        if math.isfinite(value[i]) and math.isfinite(filtered[i]):
            filtered[i] = alpha * filtered[i] + (1.0 - alpha) * value[i]
        else:
            filtered[i] = value[i]
