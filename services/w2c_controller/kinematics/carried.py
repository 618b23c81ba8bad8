"""Forces that act on the subtree of each body, summed up, compiled; `statics` says what for."""

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]
Contacts = tuple[bool, bool, bool, bool]

LOADS = 21
FORCE, POINTS, SOLE_FORCE, SOLE_MOMENT, MOMENT = 0, 3, 12, 15, 18
"""Where F, W (row by row), force and moment of the soles, and the moments that are constant stand
among the loads of a body."""


@compiled
def sum_loads(
    parents: Indices,
    weights: Vector,
    centers: Matrix,
    bodies: Indices,
    rotations: Matrix,
    origins: Matrix,
    positions: Matrix,
    world_from_effector: Matrix,
    wrenches: Matrix,
    contact_rotations: Matrix,
    levers: Matrix,
    enabled: Contacts,
    loads: Matrix,
) -> None:
    """Fill the loads (n, 21) of the subtree of each body; see the module.

    Wrenches (4, 6) and levers (4, 3) are those of `Kinematics.update_statics`.
    """
    count = parents.shape[0]
    for k in range(count):
        for i in range(LOADS):
            loads[k, i] = 0.0
        loads[k, FORCE + 2] = weights[k]
        for i in range(3):
            center = origins[k, i]
            for j in range(3):
                center += rotations[k, i, j] * centers[k, j]
            loads[k, POINTS + 3 * i + 2] = center * weights[k]
    for e in range(4):
        if enabled[e]:
            frame = world_from_effector[e] if e < 2 else contact_rotations[e]
            _add_contact(e < 2, frame, wrenches[e], positions[e], levers[e], loads[bodies[e]])
    for i in range(count - 1):
        k = count - 1 - i
        for j in range(LOADS):
            loads[parents[k], j] += loads[k, j]


@compiled
def _add_contact(
    turns: bool, frame: Matrix, wrench: Vector, position: Vector, lever: Vector, load: Vector
) -> None:
    """Add a contact's wrench (6,), given in its frame, to the loads (21,) of its body."""
    f0 = frame[0, 0] * wrench[0] + frame[0, 1] * wrench[1] + frame[0, 2] * wrench[2]
    f1 = frame[1, 0] * wrench[0] + frame[1, 1] * wrench[1] + frame[1, 2] * wrench[2]
    f2 = frame[2, 0] * wrench[0] + frame[2, 1] * wrench[1] + frame[2, 2] * wrench[2]
    x, y, z = position[0], position[1], position[2]
    start = SOLE_FORCE if turns else FORCE
    load[start] += f0
    load[start + 1] += f1
    load[start + 2] += f2
    if turns:
        for i in range(3):
            for j in range(3):
                load[SOLE_MOMENT + i] += frame[i, j] * wrench[3 + j]
        load[SOLE_MOMENT] += y * f2 - z * f1
        load[SOLE_MOMENT + 1] += z * f0 - x * f2
        load[SOLE_MOMENT + 2] += x * f1 - y * f0
        return
    for i in range(3):
        load[POINTS + 3 * i] += position[i] * f0
        load[POINTS + 3 * i + 1] += position[i] * f1
        load[POINTS + 3 * i + 2] += position[i] * f2
    load[MOMENT] += lever[1] * f2 - lever[2] * f1
    load[MOMENT + 1] += lever[2] * f0 - lever[0] * f2
    load[MOMENT + 2] += lever[0] * f1 - lever[1] * f0
