"""Loads on the end effectors, and where they are, from what the robot measures.

Feet and left wrist have force-torque sensors. The ball-ended right arm has none: its force is the
least-squares solution of J^T F = g(q) - tau over the arm's joints (quasi-static; four equations
for three unknowns). The base, which nothing measures, is turned so that the feet that stand are
level.
"""

import math
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
import pinocchio as pin

from w2c.geometry import base_from_midfeet
from w2c.messages import RobotState
from w2c_controller.compiled import compiled
from w2c_controller.filters import low_pass_gain
from w2c_controller.model import BOTH_FEET, ControlledModel, FeetOnGround
from w2c_controller.parameters import FEET, LEFT_HAND, RIGHT_HAND

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]

FORCE_CUTOFF_HZ = 10.0
DAMPING = 1e-6
"""Keeps the equations solvable with a stretched arm [m^2]."""


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
    soles: Matrix = field(default_factory=lambda: np.tile(np.eye(3), (2, 1, 1)))
    """(2, 3, 3) base_from_sole, left, right"""

    def force(self, effector: int) -> Vector:
        """Return the force (3,) on an end effector: on a foot in its sole frame [N]."""
        return np.asarray(self.feet[effector, :3] if effector in FEET else self.hands[effector - 2])


class LoadEstimator:
    """Keeps the filters of the measured loads."""

    def __init__(self, controlled: ControlledModel, dt: float) -> None:
        self._controlled = controlled
        # A model of its own: its gravity turns while its base stays at the origin.
        self._model = pin.Model(controlled.model)
        self._data = self._model.createData()
        self._gravity = np.array(self._model.gravity.linear)
        self._arm = controlled.joints_of(RIGHT_HAND)
        self._q = pin.neutral(self._model)
        self._alpha = low_pass_gain(FORCE_CUTOFF_HZ, dt)
        self._raw = np.full(18 + controlled.nj, np.nan)
        self._filtered = np.full(18 + controlled.nj, np.nan)

    def update(self, state: RobotState, feet_on_ground: FeetOnGround = BOTH_FEET) -> Measured:
        """Return the loads of one state; NaN where a sensor says NaN."""
        controlled, raw = self._controlled, self._raw
        joints = state.position[controlled.joint_indices]
        torque = state.torque[controlled.joint_indices]
        positions, soles = np.full((4, 3), np.nan), np.full((2, 3, 3), np.nan)
        raw[:12] = state.sole_wrenches.ravel()
        raw[12:18] = np.nan
        raw[18:] = torque
        if np.isfinite(joints).all():
            self._update_frames(joints, positions, soles)
            world_from_base = _standing_rotation(soles, feet_on_ground)
            self._feel(state.left_wrist_wrench[:3], torque, world_from_base)
        _low_pass(self._alpha, raw, self._filtered)
        filtered = self._filtered.copy()
        return Measured(
            feet=filtered[:12].reshape(2, 6),
            hands=filtered[12:18].reshape(2, 3),
            torque=filtered[18:],
            positions=positions,
            soles=soles,
        )

    def _update_frames(self, joints: Vector, positions: Matrix, soles: Matrix) -> None:
        """Fill positions and sole rotations in the base frame; the data keeps the Jacobians."""
        self._q[7:] = joints
        pin.computeJointJacobians(self._model, self._data, self._q)
        for k, frame in enumerate(self._controlled.frames):
            placement = pin.updateFramePlacement(self._model, self._data, frame)
            positions[k] = placement.translation
            if k in FEET:
                soles[k] = placement.rotation

    def _feel(self, wrist_force: Vector, torque: Vector, world_from_base: Matrix) -> None:
        """Fill the raw forces on the hands, in the world."""
        model, data, frames, arm = self._model, self._data, self._controlled.frames, self._arm
        left = data.oMf[frames[LEFT_HAND]].rotation
        self._raw[12:15] = world_from_base @ (left @ wrist_force)
        jacobian = pin.getFrameJacobian(
            model, data, frames[RIGHT_HAND], pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        )[:3, arm]
        model.gravity.linear = self._gravity @ world_from_base
        residual = pin.computeGeneralizedGravity(model, data, self._q)[arm] - torque[arm - 6]
        normal_equations = jacobian @ jacobian.T
        normal_equations.ravel()[::4] += DAMPING
        force = np.linalg.solve(normal_equations, jacobian @ residual)
        self._raw[15:18] = world_from_base @ force


def _standing_rotation(soles: Matrix, feet: FeetOnGround) -> Matrix:
    """Return world_from_base (3, 3) where the soles that stand are level, on average."""
    left, right = np.eye(4), np.eye(4)
    left[:3, :3], right[:3, :3] = soles[feet[0]], soles[feet[1]]
    return np.asarray(base_from_midfeet(left, right)[:3, :3].T)


@compiled
def _low_pass(alpha: float, value: Vector, filtered: Vector) -> None:
    """Filter each component; one that is not finite passes, and starts its filter again."""
    for i in range(value.shape[0]):
        if math.isfinite(value[i]) and math.isfinite(filtered[i]):
            filtered[i] = alpha * filtered[i] + (1.0 - alpha) * value[i]
        else:
            filtered[i] = value[i]
