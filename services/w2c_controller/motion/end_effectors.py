"""How the target of a free hand or foot becomes the target of the QP: one filter each."""

import numpy as np
import numpy.typing as npt

from w2c_controller.kinematics.model import Kinematics
from w2c_controller.motion.pose_filters import PoseFilters
from w2c_controller.parameters import FEET, HANDS
from w2c_controller.seiko.retargeting import Retargeting

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]


class EndEffectors:
    """Targets and filters of hands and feet. A free one without a goal stays where it was left."""

    def __init__(self, retargeting: Retargeting, at_rest: Kinematics) -> None:
        """Start where the desired posture has the hands.

        Args:
            retargeting: Owns the desired posture.
            at_rest: Of the posture that hands return to.
        """
        self._retargeting = retargeting
        kinematics = retargeting.kinematics
        self.rest = {k: at_rest.positions[k].copy() for k in HANDS}
        """(3,) where a released hand goes, in the world [m]"""
        self.targets = kinematics.positions.copy()
        """(4, 3) where each shall be, in the world [m]"""
        self.rotations = kinematics.rotations.copy()
        """(4, 3, 3) world_from_effector wanted; matters where a hand has an orientation"""
        self._rest_rotations = {k: at_rest.rotations[k].copy() for k in HANDS}
        for k, rotation in self._rest_rotations.items():
            self.rotations[k] = rotation
        self._filters = PoseFilters(
            retargeting.parameters.filters,
            retargeting.dt,
            kinematics.positions,
            kinematics.rotations,
        )
        self.displacements = np.zeros((4, 3))
        """(4, 3) of the targets, by which end effectors give way to forces [m]"""

    def position(self, effector: int) -> Vector:
        """Return where the desired posture has an end effector (3,), a copy [m]."""
        return np.array(self._retargeting.kinematics.positions[effector])

    def velocity(self, effector: int) -> Vector:
        """Return how the desired posture moves an end effector (3,) [m/s]."""
        jacobian = self._retargeting.kinematics.jacobians[effector, :3]
        return np.asarray(jacobian @ self._retargeting.state.velocity)

    def speed(self, effector: int) -> float:
        """Return how fast the desired posture moves an end effector [m/s]."""
        return float(np.linalg.norm(self.velocity(effector)))

    def relax(self, hand: int) -> None:
        """Let a hand turn back to its orientation at rest."""
        self.rotations[hand] = self._rest_rotations[hand]

    def stop(self, effector: int) -> None:
        """Let an end effector stay where it is; a foot also as it is turned."""
        self.targets[effector] = self.position(effector)
        if effector in FEET:
            self.rotations[effector] = self._retargeting.kinematics.rotations[effector]
        self._reset(effector)

    def step(self) -> None:
        """Give the QP its targets of this tick."""
        state, kinematics = self._retargeting.state, self._retargeting.kinematics
        self._filters.step(
            state.enabled,
            self.targets,
            self.rotations,
            self.displacements,
            kinematics.positions,
            kinematics.rotations,
            state.target_positions,
            state.target_rotations,
        )

    def _reset(self, effector: int) -> None:
        kinematics = self._retargeting.kinematics
        self.displacements[effector] = 0.0
        self._filters.reset(effector, kinematics.positions, kinematics.rotations)
