"""How each hand's target becomes the target of the QP: one filter a hand, reset in contact."""

import numpy as np
import numpy.typing as npt

from w2c_controller.filters import HandFilter
from w2c_controller.model import Kinematics
from w2c_controller.parameters import HANDS
from w2c_controller.retargeting import Retargeting

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]


class Hands:
    """Targets and filters of both hands. A hand without a goal stays where its last one left it."""

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
        self.targets = {k: kinematics.positions[k].copy() for k in HANDS}
        self._rest_rotations = {k: at_rest.rotations[k].copy() for k in HANDS}
        self.rotations = {k: rotation.copy() for k, rotation in self._rest_rotations.items()}
        """(3, 3) world_from_hand wanted; matters where a hand has an orientation"""
        self._filters = {
            k: HandFilter(filters, retargeting.dt, kinematics.positions[k], kinematics.rotations[k])
            for k in HANDS
        }

    def position(self, hand: int) -> Vector:
        """Return where the desired posture has a hand (3,), a copy [m]."""
        return np.array(self._retargeting.kinematics.positions[hand])

    def speed(self, hand: int) -> float:
        """Return how fast the desired posture moves a hand [m/s]."""
        jacobian = self._retargeting.kinematics.jacobians[hand, :3]
        return float(np.linalg.norm(jacobian @ self._retargeting.state.velocity))

    def relax(self, hand: int) -> None:
        """Let a hand turn back to its orientation at rest."""
        self.rotations[hand] = self._rest_rotations[hand]

    def stop(self, hand: int) -> None:
        """Let a hand stay where it is."""
        self.targets[hand] = self.position(hand)
        self._reset(hand)

    def step(self) -> None:
        """Give the QP its targets of this tick."""
        state = self._retargeting.state
        kinematics = self._retargeting.kinematics
        for k in HANDS:
            if state.enabled[k]:
                self._reset(k)
                continue
            self._filters[k].step(
                self.targets[k],
                self.rotations[k],
                kinematics.positions[k],
                kinematics.rotations[k],
            )
            state.target_positions[k] = self._filters[k].position
            state.target_rotations[k] = self._filters[k].rotation

    def _reset(self, hand: int) -> None:
        kinematics = self._retargeting.kinematics
        self._filters[hand].reset(kinematics.positions[hand], kinematics.rotations[hand])
