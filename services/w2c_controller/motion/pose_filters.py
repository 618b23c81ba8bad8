"""What stands between a target pose and the QP: anti-windup, a low-pass, a bang-bang planner."""

from typing import Final

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled
from w2c_controller.kinematics.rotations import rotation_between, turn
from w2c_controller.motion.filters import bang_bang_speed, low_pass_gain
from w2c_controller.parameters import Filters
from w2c_controller.seiko.corrections import clamped_share

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]
Flags = npt.NDArray[np.int8]
Contacts = tuple[bool, bool, bool, bool]

LEAD_POSITION: Final = 0
LEAD_ROTATION: Final = 1
SPEED: Final = 2
ACCELERATION: Final = 3
ANGULAR_SPEED: Final = 4
ANGULAR_ACCELERATION: Final = 5
REST: Final = 6
"""Where each setting stands in a vector of settings; the last is 1 - alpha of the low-pass."""


@compiled
def filter_position(
    dt: float,
    settings: Vector,
    target: Vector,
    effector: Vector,
    smooth: Vector,
    speed: Vector,
    position: Vector,
) -> None:
    """Move a filtered position (3,) by one tick towards a target."""
    u, v, w = target[0] - effector[0], target[1] - effector[1], target[2] - effector[2]
    share = clamped_share(u, v, w, settings[LEAD_POSITION])
    for i in range(3):
        anchor = effector[i] + share * (target[i] - effector[i])
        smooth[i] += settings[REST] * (anchor - smooth[i])
        error = smooth[i] - position[i]
        speed[i] = bang_bang_speed(error, speed[i], settings[SPEED], settings[ACCELERATION], dt)
        position[i] += dt * speed[i]


@compiled
def filter_rotation(
    dt: float,
    settings: Vector,
    target: Matrix,
    effector: Matrix,
    smooth: Matrix,
    speed: Vector,
    rotation: Matrix,
    work: Vector,
    anchor: Matrix,
) -> None:
    """Move a filtered rotation (3, 3) by one tick to a target; the last two are overwritten."""
    rotation_between(target, effector, work)
    share = clamped_share(work[0], work[1], work[2], settings[LEAD_ROTATION])
    for i in range(3):
        for j in range(3):
            anchor[i, j] = effector[i, j]
    turn(anchor, share * work[0], share * work[1], share * work[2])
    rotation_between(anchor, smooth, work)
    rest = settings[REST]
    turn(smooth, rest * work[0], rest * work[1], rest * work[2])
    rotation_between(smooth, rotation, work)
    for i in range(3):
        speed[i] = bang_bang_speed(
            work[i], speed[i], settings[ANGULAR_SPEED], settings[ANGULAR_ACCELERATION], dt
        )
    turn(rotation, dt * speed[0], dt * speed[1], dt * speed[2])


@compiled
def rest_at(
    k: int,
    positions: Matrix,
    rotations: Matrix,
    smooth_positions: Matrix,
    smooth_rotations: Matrix,
    speeds: Matrix,
    turns: Matrix,
    filtered_positions: Matrix,
    filtered_rotations: Matrix,
) -> None:
    """Start the filter of one end effector again, at rest, from its pose."""
    for i in range(3):
        smooth_positions[k, i] = filtered_positions[k, i] = positions[k, i]
        speeds[k, i] = turns[k, i] = 0.0
        for j in range(3):
            smooth_rotations[k, i, j] = filtered_rotations[k, i, j] = rotations[k, i, j]


@compiled
def filter_poses(
    dt: float,
    settings: Vector,
    enabled: Contacts,
    targets: Matrix,
    wanted: Matrix,
    displacements: Matrix,
    positions: Matrix,
    rotations: Matrix,
    fixed: Flags,
    smooth_positions: Matrix,
    smooth_rotations: Matrix,
    speeds: Matrix,
    turns: Matrix,
    filtered_positions: Matrix,
    filtered_rotations: Matrix,
    work: Vector,
    anchor: Matrix,
    target_positions: Matrix,
    target_rotations: Matrix,
) -> None:
    """Give the QP the targets (4, 3), (4, 3, 3) of what is free; see `PoseFilters.step`."""
    for k in range(4):
        if enabled[k]:
            fixed[k] = 1
            continue
        if fixed[k] != 0:
            fixed[k] = 0
            rest_at(
                k,
                positions,
                rotations,
                smooth_positions,
                smooth_rotations,
                speeds,
                turns,
                filtered_positions,
                filtered_rotations,
            )
            for i in range(3):
                displacements[k, i] = 0.0
        # Without what gave way: a lead from the displaced hand would carry the filter off with it.
        for i in range(3):
            work[i] = positions[k, i] - displacements[k, i]
        filter_position(
            dt,
            settings,
            targets[k],
            work,
            smooth_positions[k],
            speeds[k],
            filtered_positions[k],
        )
        filter_rotation(
            dt,
            settings,
            wanted[k],
            rotations[k],
            smooth_rotations[k],
            turns[k],
            filtered_rotations[k],
            work,
            anchor,
        )
        for i in range(3):
            # Behind the filter, whose delay would make a hand on a hard surface swing.
            target_positions[k, i] = filtered_positions[k, i] + displacements[k, i]
            for j in range(3):
                target_rotations[k, i, j] = filtered_rotations[k, i, j]


class PoseFilters:
    """Turns target poses that may jump into those that the QP can follow; one each end effector."""

    def __init__(self, filters: Filters, dt: float, positions: Matrix, rotations: Matrix) -> None:
        """Start at rest from these poses (4, 3) and (4, 3, 3)."""
        self.positions = positions.copy()
        """(4, 3) filtered"""
        self.rotations = rotations.copy()
        """(4, 3, 3) filtered"""
        self._dt = dt
        self._settings = np.array(
            [
                filters.lead_position,
                filters.lead_rotation,
                filters.speed,
                filters.acceleration,
                filters.angular_speed,
                filters.angular_acceleration,
                1.0 - low_pass_gain(filters.low_pass_hz, dt),
            ]
        )
        self._fixed = np.zeros(4, dtype=np.int8)
        """Which were contacts in the last tick"""
        self._state = (
            positions.copy(),
            rotations.copy(),
            np.zeros((4, 3)),
            np.zeros((4, 3)),
            self.positions,
            self.rotations,
        )
        self._work, self._anchor = np.zeros(3), np.zeros((3, 3))

    def reset(self, effector: int, positions: Matrix, rotations: Matrix) -> None:
        """Start the filter of one end effector again, at rest, from its pose among these."""
        rest_at(effector, positions, rotations, *self._state)

    def step(
        self,
        enabled: Contacts,
        targets: Matrix,
        wanted: Matrix,
        displacements: Matrix,
        positions: Matrix,
        rotations: Matrix,
        target_positions: Matrix,
        target_rotations: Matrix,
    ) -> None:
        """Move the filters of what is free by one tick; contacts start from rest when freed.

        Args:
            enabled: Which are contacts.
            targets: (4, 3) where each shall be, in the world [m].
            wanted: (4, 3, 3) how it shall be turned.
            displacements: (4, 3) added behind the filters [m]; zeroed where a contact is freed.
            positions: (4, 3) where the desired posture has them: the command leads by a bounded
                distance.
            rotations: (4, 3, 3) of the desired posture.
            target_positions: (4, 3) out: for the QP.
            target_rotations: (4, 3, 3) out
        """
        filter_poses(
            self._dt,
            self._settings,
            enabled,
            targets,
            wanted,
            displacements,
            positions,
            rotations,
            self._fixed,
            *self._state,
            self._work,
            self._anchor,
            target_positions,
            target_rotations,
        )
