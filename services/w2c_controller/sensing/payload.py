"""What hangs on the hands: measured while they are free and at rest, and told to the model.

The Retargeting plans with the weights of the bodies. A mass in the hand that it does not know of
moves the true centre of pressure by centimetres, and feedback alone finds out seconds too late. A
force that points down on a free hand is taken for the weight of a point mass at the hand's frame.
"""

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from w2c_controller.kinematics.model import ControlledModel
from w2c_controller.parameters import HANDS
from w2c_controller.seiko.force_parameters import ForceParameters
from w2c_controller.sensing.loads import Measured

Vector = npt.NDArray[np.float64]

GRAVITY = 9.81


class Payloads:
    """Keeps the masses (2,) of both hands, and the weights of the bodies that hold them."""

    def __init__(self, controlled: ControlledModel, parameters: ForceParameters, dt: float) -> None:
        """Start with empty hands.

        Args:
            controlled: Whose bodies learn what they carry: all kinematics of it do.
            parameters: Without force control nothing is learnt.
            dt: Between two calls of `learn` [s].
        """
        tree = controlled.tree
        self._weights, self._centers = tree.weights, tree.centers
        self._bodies = [int(tree.effector_bodies[k]) for k in HANDS]
        self._arms = [tree.effector_origins[k].copy() for k in HANDS]
        self._own_weights = [float(tree.weights[body]) for body in self._bodies]
        self._own_centers = [tree.centers[body].copy() for body in self._bodies]
        self._learns = parameters.mode != "off"
        self._least = parameters.payload_least
        self._step = parameters.payload_rate * dt
        self.masses = np.zeros(2)
        """(2,) left, right [kg]"""
        self._empty = True
        """Whether both are zero"""

    def begin(self, measured: Measured, free: tuple[bool, bool]) -> None:
        """Take what free hands carry at the start as it is measured, at once."""
        for row in range(2):
            self._carry(row, self._measure(measured, row) if free[row] else 0.0)

    def learn(self, measured: Measured, free: tuple[bool, bool]) -> None:
        """Follow what free hands carry, slowly: the balance has to follow the model.

        Args:
            measured: With the weight of all that hangs on the hands.
            free: Left, right: hands in the air and at rest. The others keep their mass.
        """
        for row in range(2):
            if free[row]:
                change = self._measure(measured, row) - self.masses[row]
                if change != 0.0:
                    step = min(max(change, -self._step), self._step)
                    self._carry(row, float(self.masses[row]) + step)

    def relieve(self, measured: Measured) -> Measured:
        """Return the forces without the weights of the masses: what contacts exert."""
        if self._empty:
            return measured
        hands = measured.hands.copy()
        hands[:, 2] += GRAVITY * self.masses
        return replace(measured, hands=hands)

    def _measure(self, measured: Measured, row: int) -> float:
        """Return the mass on a hand [kg]; what the sensor cannot tell leaves it as it is."""
        if not self._learns:
            return 0.0
        mass = -float(measured.hands[row, 2]) / GRAVITY
        if not np.isfinite(mass):
            return float(self.masses[row])
        return mass if mass > self._least else 0.0

    def _carry(self, row: int, mass: float) -> None:
        body, own = self._bodies[row], self._own_weights[row]
        force = -GRAVITY * mass
        self.masses[row] = mass
        self._empty = not self.masses.any()
        self._weights[body] = own + force
        self._centers[body] = (own * self._own_centers[row] + force * self._arms[row]) / (
            own + force
        )
