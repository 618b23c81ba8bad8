"""Loads on the end effectors from what the robot measures.

Feet and left wrist have force-torque sensors. The ball-ended right arm has none: its force is the
least-squares solution of J^T F = g(q) - tau over the arm's joints (quasi-static; four equations
for three
unknowns). The base, which nothing measures, is the one that keeps the feet where they stand.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pinocchio as pin

from w2c.messages import RobotState
from w2c_controller.filters import LowPass
from w2c_controller.model import ControlledModel, standing_configuration
from w2c_controller.parameters import LEFT_HAND, RIGHT_HAND

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]

FORCE_CUTOFF_HZ = 10.0
DAMPING = 1e-6
"""Keeps the equations solvable with a stretched arm [m^2]."""


@dataclass(frozen=True)
class Measured:
    """Forces that the environment exerts, filtered."""

    feet: Vector
    """(2,) normal forces, left, right [N]"""
    hands: Matrix
    """(2, 3) in the world, left, right [N]"""


class LoadEstimator:
    """Keeps the filters of the measured loads."""

    def __init__(self, controlled: ControlledModel, dt: float) -> None:
        self._controlled = controlled
        self._data = controlled.model.createData()
        self._arm = controlled.joints_of(RIGHT_HAND)
        self._hand_frames = (controlled.frames[LEFT_HAND], controlled.frames[RIGHT_HAND])
        self._feet = LowPass(FORCE_CUTOFF_HZ, dt)
        self._hands = LowPass(FORCE_CUTOFF_HZ, dt)

    def update(self, state: RobotState) -> Measured:
        """Return the loads of one state; NaN where a sensor says NaN."""
        indices = self._controlled.joint_indices
        joints, torque = state.position[indices], state.torque[indices]
        feet = self._feet.step(state.sole_wrenches[:, 2])
        if not np.isfinite(joints).all():
            return Measured(feet=feet, hands=np.full((2, 3), np.nan))
        model, data = self._controlled.model, self._data
        q = standing_configuration(self._controlled, joints, data)
        pin.computeJointJacobians(model, data, q)
        left = pin.updateFramePlacement(model, data, self._hand_frames[0]).rotation
        hands = np.empty((2, 3))
        hands[0] = left @ state.left_wrist_wrench[:3]
        pin.updateFramePlacement(model, data, self._hand_frames[1])
        jacobian = pin.getFrameJacobian(
            model, data, self._hand_frames[1], pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        )[:3, self._arm]
        gravity = pin.computeGeneralizedGravity(model, data, q)[self._arm]
        residual = gravity - torque[self._arm - 6]
        normal_equations = jacobian @ jacobian.T + DAMPING * np.eye(3)
        hands[1] = np.linalg.solve(normal_equations, jacobian @ residual)
        return Measured(feet=feet, hands=self._hands.step(hands))


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
