"""Free end effectors give way to forces that nobody asked for.

A force beyond a deadband moves the target of a free hand or foot with it:

    speed = gain (|force| - deadband), at most a limit

(SEIKO Controller: Rouxel, Ivaldi and Mouret, RA-L 2024). Where the force is gone, the target
returns slowly. What an end effector reads in the air, such as the weight of what it holds, is its
zero; the zero follows readings below half of the deadband.
"""

import math

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled
from w2c_controller.parameters import FEET
from w2c_controller.seiko.contacts import Enabled
from w2c_controller.seiko.force_parameters import AdmittanceGains, ForceParameters
from w2c_controller.sensing.loads import Measured

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]


class Admittance:
    """How far each end effector has given way."""

    def __init__(self, parameters: ForceParameters, dt: float) -> None:
        """Start where nothing pushes.

        Args:
            parameters: Of force control; without it nothing gives way.
            dt: Between two steps [s].
        """
        self._dt = dt
        self._active = parameters.mode != "off"
        gains = [
            parameters.foot_admittance if k in FEET else parameters.hand_admittance
            for k in range(4)
        ]
        self._gains = np.array([_as_row(gain) for gain in gains])
        self._zero = np.full((4, 3), np.nan)
        self._force = np.zeros(3)
        self.displacements = np.zeros((4, 3))
        """(4, 3) of the targets, in the world [m]"""

    def step(self, measured: Measured, rotations: Matrix, enabled: Enabled) -> None:
        """Update the displacements; those of contacts are zero.

        Args:
            measured: Forces of the environment; one that is NaN holds its displacement.
            rotations: (4, 3, 3) world_from_effector; those of the feet are used.
            enabled: Which end effectors are contacts.
        """
        if not self._active:
            return
        give_way(
            self._dt,
            self._gains,
            measured.feet,
            measured.hands,
            rotations,
            enabled,
            self._force,
            self._zero,
            self.displacements,
        )


def _as_row(gains: AdmittanceGains) -> Vector:
    return np.array(
        [
            gains.force_deadband,
            gains.force_gain,
            gains.speed,
            gains.return_speed,
            gains.farthest,
            gains.zero_time,
        ]
    )


@compiled
def give_way(
    dt: float,
    gains: Matrix,
    feet: Matrix,
    hands: Matrix,
    rotations: Matrix,
    enabled: Enabled,
    force: Vector,
    zero: Matrix,
    displacements: Matrix,
) -> None:
    """Move all displacements (4, 3) by one step; `force` (3,) is overwritten."""
    for k in range(4):
        if enabled[k]:
            for i in range(3):
                displacements[k, i] = 0.0
            continue
        for i in range(3):
            force[i] = hands[k - 2, i] if k >= 2 else 0.0
            for j in range(3 if k < 2 else 0):
                force[i] += rotations[k, i, j] * feet[k, j]
        _move(dt, gains[k], force, zero[k], displacements[k])


@compiled
def _move(dt: float, gains: Vector, force: Vector, zero: Vector, displacement: Vector) -> None:
    """Move one displacement and its zero by one step."""
    if not math.isfinite(force[0] + force[1] + force[2]):
        return
    if not math.isfinite(zero[0] + zero[1] + zero[2]):
        for i in range(3):
            zero[i] = force[i]
    felt = 0.0
    away = 0.0
    for i in range(3):
        felt += (force[i] - zero[i]) ** 2
        away += displacement[i] ** 2
    felt, away = math.sqrt(felt), math.sqrt(away)
    deadband = gains[0]
    if felt > deadband:
        speed = min(gains[1] * (felt - deadband), gains[2])
        for i in range(3):
            displacement[i] += dt * speed * (force[i] - zero[i]) / felt
    elif felt < 0.5 * deadband:
        share = max(1.0 - dt * gains[3] / away, 0.0) if away > 0.0 else 0.0
        for i in range(3):
            displacement[i] *= share
            zero[i] += dt / gains[5] * (force[i] - zero[i])
    away = math.sqrt(displacement[0] ** 2 + displacement[1] ** 2 + displacement[2] ** 2)
    if away > gains[4]:
        for i in range(3):
            displacement[i] *= gains[4] / away
