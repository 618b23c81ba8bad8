"""How the target of a free hand or foot becomes the target of the QP: one filter each."""

import numpy as np
import numpy.typing as npt

from w2c_controller.filters import HandFilter
from w2c_controller.model import Kinematics
from w2c_controller.parameters import FEET, HANDS
from w2c_controller.retargeting import Retargeting

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]


class Hands:
    """Targets and filters of hands and feet. A free one without a goal stays where it was left."""

    def __init__(self, retargeting: Retargeting, at_rest: Kinematics) -> None:
        """Start where the desired posture has the hands.

        Args:
            retargeting: Owns the desired posture.
            at_rest: Of the posture that hands return to.
        """
        self._retargeting = retargeting
        filters = retargeting.parameters.filters
        kinematics = retargeting.kinematics
        self.rest = {k: at_rest.positions[k].copy() for k in HANDS}
        """(3,) where a released hand goes, in the world [m]"""
        self.targets = {k: kinematics.positions[k].copy() for k in range(4)}
        self._rest_rotations = {k: at_rest.rotations[k].copy() for k in HANDS}
        self.rotations = {k: kinematics.rotations[k].copy() for k in FEET}
        """(3, 3) world_from_effector wanted; matters where a hand has an orientation"""
        self.rotations |= {k: rotation.copy() for k, rotation in self._rest_rotations.items()}
        self._filters = {
            k: HandFilter(filters, retargeting.dt, kinematics.positions[k], kinematics.rotations[k])
            for k in range(4)
        }
        self.displacements = np.zeros((4, 3))
        """(4, 3) of the targets, by which end effectors give way to forces [m]"""
        self._fixed = [False] * 4
        """Which were contacts in the last tick"""

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
            self.rotations[effector] = self._retargeting.kinematics.rotations[effector].copy()
        self._reset(effector)

    def step(self) -> None:
        """Give the QP its targets of this tick."""
        state = self._retargeting.state
        kinematics = self._retargeting.kinematics
        for k in range(4):
            if state.enabled[k]:
                self._fixed[k] = True
                continue
            if self._fixed[k]:
                self._fixed[k] = False
                self._reset(k)
            self._filters[k].step(
                self.targets[k],
                self.rotations[k],
                kinematics.positions[k],
                kinematics.rotations[k],
            )
            # Behind the filter, whose delay would make a hand on a hard surface swing.
            state.target_positions[k] = self._filters[k].position + self.displacements[k]
            state.target_rotations[k] = self._filters[k].rotation

    def _reset(self, effector: int) -> None:
        kinematics = self._retargeting.kinematics
        self.displacements[effector] = 0.0
        self._filters[effector].reset(
            kinematics.positions[effector], kinematics.rotations[effector]
        )
