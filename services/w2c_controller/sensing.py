"""Loads on the end effectors from what the robot measures.

Feet and left wrist have force-torque sensors. The ball-ended right arm has none: its force is the
least-squares solution of J^T F = g(q) - tau over the arm's joints (quasi-static; four equations
for three
unknowns). The base, which nothing measures, is the one that keeps the feet where they stand.
"""

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
import pinocchio as pin

from w2c.messages import RobotState
from w2c_controller.filters import LowPass
from w2c_controller.model import BOTH_FEET, ControlledModel, FeetOnGround, standing_configuration
from w2c_controller.parameters import FEET, LEFT_HAND, RIGHT_HAND

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]

FORCE_CUTOFF_HZ = 10.0
DAMPING = 1e-6
"""Keeps the equations solvable with a stretched arm [m^2]."""


@dataclass(frozen=True)
class Measured:
    """Forces that the environment exerts, filtered, and where the end effectors are."""

    feet: Matrix
    """(2, 6) force, torque in the sole frames, left, right [N, Nm]"""
    hands: Matrix
    """(2, 3) in the world, left, right [N]"""
    positions: Matrix = field(default_factory=lambda: np.zeros((4, 3)))
    """(4, 3) of the end effectors by the measured joint angles [m]; only differences have a
    meaning, as nothing measures the base"""
    soles: Matrix = field(default_factory=lambda: np.tile(np.eye(3), (2, 1, 1)))
    """(2, 3, 3) rotations of the soles, left, right, in the frame of the positions"""

    def force(self, effector: int) -> Vector:
        """Return the force (3,) on an end effector: on a foot in its sole frame [N]."""
        return np.asarray(self.feet[effector, :3] if effector in FEET else self.hands[effector - 2])


class LoadEstimator:
    """Keeps the filters of the measured loads."""

    def __init__(self, controlled: ControlledModel, dt: float) -> None:
        self._controlled = controlled
        self._data = controlled.model.createData()
        self._arm = controlled.joints_of(RIGHT_HAND)
        self._feet = LowPass(FORCE_CUTOFF_HZ, dt)
        self._hands = LowPass(FORCE_CUTOFF_HZ, dt)

    def update(self, state: RobotState, feet_on_ground: FeetOnGround = BOTH_FEET) -> Measured:
        """Return the loads of one state; NaN where a sensor says NaN."""
        indices = self._controlled.joint_indices
        joints, torque = state.position[indices], state.torque[indices]
        feet = self._feet.step(state.sole_wrenches)
        if not np.isfinite(joints).all():
            return Measured(feet=feet, hands=np.full((2, 3), np.nan))
        model, data = self._controlled.model, self._data
        q = standing_configuration(self._controlled, joints, data, feet_on_ground)
        pin.computeJointJacobians(model, data, q)
        positions, rotations = np.empty((4, 3)), np.empty((4, 3, 3))
        for k, frame in enumerate(self._controlled.frames):
            placement = pin.updateFramePlacement(model, data, frame)
            positions[k], rotations[k] = placement.translation, placement.rotation
        hands = np.empty((2, 3))
        hands[0] = rotations[LEFT_HAND] @ state.left_wrist_wrench[:3]
        jacobian = pin.getFrameJacobian(
            model,
            data,
            self._controlled.frames[RIGHT_HAND],
            pin.ReferenceFrame.LOCAL_WORLD_ALIGNED,
        )[:3, self._arm]
        gravity = pin.computeGeneralizedGravity(model, data, q)[self._arm]
        residual = gravity - torque[self._arm - 6]
        normal_equations = jacobian @ jacobian.T + DAMPING * np.eye(3)
        hands[1] = np.linalg.solve(normal_equations, jacobian @ residual)
        return Measured(
            feet=feet, hands=self._hands.step(hands), positions=positions, soles=rotations[:2]
        )


class Feeler:
    """What a hand feels since it was free: the force without what it read in the air."""

    def __init__(self, normal: Vector | None = None) -> None:
        """Start without a tare.

        Args:
            normal: (3,) unit, of the surface expected, in the world; None: up.
        """
        self.normal = np.array([0.0, 0.0, 1.0]) if normal is None else normal
        self._tare = np.zeros(3)

    def tare(self, force: Vector) -> None:
        """Take a force (3,) measured in the air as zero."""
        self._tare = force.copy()

    def force(self, measured: Vector) -> float:
        """Return the size of the force [N]; NaN where the sensor says so."""
        return float(np.linalg.norm(measured - self._tare))

    def normal_force(self, measured: Vector) -> float:
        """Return the force out of the surface [N]."""
        return float(self.normal @ (measured - self._tare))
