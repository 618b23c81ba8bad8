"""What the end effectors feel of their surroundings: the force beside what was read in the air."""

import math

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled
from w2c_controller.parameters import FEET
from w2c_controller.sensing.loads import Measured

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]

UP = np.array([0.0, 0.0, 1.0])


class Feelers:
    """A tare and a surface normal for each end effector; zero and up until something says else.

    Forces of hands are in the world, forces of feet in their sole frames.
    """

    def __init__(self) -> None:
        self.normals: Matrix = np.tile(UP, (4, 1))
        """(4, 3) unit, out of the surface expected or leaned on"""
        self.tares: Matrix = np.zeros((4, 3))
        """(4, 3) what is read without contact [N]"""

    def expect(self, effector: int, normal: Vector) -> None:
        """Note the normal (3,) of the surface that an end effector goes to, in the world."""
        self.normals[effector] = UP if effector in FEET else normal

    def tare(self, effector: int, measured: Measured) -> None:
        """Take what is measured now as zero."""
        self.tares[effector] = measured.force(effector)

    def feel(self, effector: int, measured: Measured, limit: float, share: float) -> float:
        """Return the size of the force on what moves in the air [N]; NaN where the sensor says so.

        Args:
            effector: What moves.
            measured: Forces.
            limit: A smaller force may be weight that turns: the tare follows it [N].
            share: How much of it becomes zero, in [0, 1].
        """
        return float(_feel(measured.force(effector), self.tares[effector], limit, share))

    def normal_force(self, effector: int, measured: Measured) -> float:
        """Return the force out of the surface [N]; NaN where the sensor says so."""
        return float(self.normals[effector] @ (measured.force(effector) - self.tares[effector]))


@compiled
def _feel(force: Vector, tare: Vector, limit: float, share: float) -> float:
    """Return the size of a force (3,) beside its tare (3,), which follows where it is small."""
    square = 0.0
    for i in range(3):
        square += (force[i] - tare[i]) ** 2
    size = math.sqrt(square)
    if size <= limit:
        for i in range(3):
            tare[i] += share * (force[i] - tare[i])
    return size
