"""How the controller begins with a robot: standing, or leaning already."""

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from w2c.geometry import frame_from_normal
from w2c_controller.parameters import EFFECTORS, HANDS
from w2c_controller.safety import Hazard
from w2c_controller.sensing import Measured

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]

FRESH_POSTURE = 0.05
"""A robot within this of its initial posture starts from it exactly [rad]."""
LEANING_FORCE = 15.0
"""A hand that measures more at the start leans [N]."""
HANGING = -0.7
"""A force whose vertical share is below this is a load that hangs on the hand, no support."""


def find_supports(measured: Measured) -> dict[int, Matrix]:
    """Return the hands that bear weight, each with its world_from_contact (3, 3)."""
    supports = {}
    for row, k in enumerate(HANDS):
        force = measured.hands[row]
        size = float(np.linalg.norm(force))
        if size > LEANING_FORCE and force[2] > HANGING * size:
            supports[k] = frame_from_normal(force)
    return supports


def starting_posture(joints: Vector, initial: Vector, supports: Mapping[int, Matrix]) -> Vector:
    """Return the joint angles (n,) to start from: the initial ones where the robot stands there."""
    fresh = not supports and float(np.max(np.abs(joints - initial))) < FRESH_POSTURE
    return initial if fresh else joints


def unknown_contacts(supports: Mapping[int, Matrix], measured: Measured) -> Hazard:
    """Return what forbids to start: hands bear weight, and nobody knows why."""
    forces = {k: float(np.linalg.norm(measured.hands[k - HANDS[0]])) for k in supports}
    hands = ", ".join(
        f"{EFFECTORS[k].replace('_', ' ')} {force:.0f} N" for k, force in forces.items()
    )
    text = f"hands bear weight ({hands}), and no snapshot says what they do there"
    heaviest = max(forces, key=lambda k: forces[k])
    return Hazard("no_snapshot", text, EFFECTORS[heaviest], forces[heaviest], LEANING_FORCE, "N")
