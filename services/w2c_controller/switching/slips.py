"""Which contacts slip: motion against the feet, without that of a ball that rolls; compiled.

By the measured joint angles, a hand's place in the frames of the soles, and one sole's place in the
other's, do not change while all of them stick; nothing else of the world need be known. The centre
of a ball that sticks moves nevertheless where the ball turns: by w x (r n), as it rolls. That is no
slip, and is taken off. What counts is motion within about a time constant: fast slips of all; and
slow ones of hands, which a position-controlled arm draws over a surface that is more slippery than
assumed. Those count where the measured force is well within the assumed cone: within it nothing
slides but for a wrong assumption.
"""

import math
from typing import Final

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

LOST: Final = 0
SLIPS: Final = 1
OVERLOADED: Final = 2
NOTHING: Final = -1

LOST_TIME, FAST_SHARE, SLOW_SHARE, OVERLOAD_FORCE, OVERLOAD_TIME = 0, 1, 2, 3, 4
PERIOD, SLIP_LOAD, CREEP_DISTANCE, CREEP_FRICTION = 5, 6, 7, 8
"""Where each number of the supervision stands for compiled code"""


@compiled
def follow_contacts(
    watched: Flags,
    wrenches: Matrix,
    hands: Matrix,
    positions: Matrix,
    rotations: Matrix,
    standing_rotations: Matrix,
    normals: Matrix,
    tares: Matrix,
    radii: Vector,
    missing: Vector,
    farthest: Vector,
    numbers: Vector,
    places: Matrix,
    turned: Matrix,
    slips: Matrix,
    told: Flags,
    measured: Vector,
    motion: Vector,
    allowed: Vector,
) -> int:
    """Update places and motions; returns 4 trouble + effector, or -1.

    What carries nothing does not slip; a hand that lets go, or is still to be loaded, takes hold
    where it is. Of two feet that move against each other, the one that carries less is the one
    that slips.
    """
    found = NOTHING
    for k in range(1, 4):
        motion[k] = 0.0
        feet = 1 if k == 1 else 2
        standing = int(watched[0]) + int(watched[1]) * (feet - 1)
        if not watched[k] or standing == 0:
            continue
        loose = k >= 2 and (wrenches[k, 2] < numbers[SLIP_LOAD] or measured[k] < missing[k])
        sole = 0 if watched[0] else 1
        x = y = z = 0.0
        if radii[k] > 0.0:
            x, y, z = roll(rotations, standing_rotations, normals, sole, k, radii[k], turned[k])
        creeps = (
            k >= 2
            and force_along(hands[k - 2], tares[k], normals[k])
            < numbers[CREEP_FRICTION] * measured[k]
        )
        fast = slow = 0.0
        for i in range(3):
            place, rolled = place_against(watched[:feet], positions, rotations, k, i, x, y, z)
            step = (place - rolled) / standing - places[k, i]
            places[k, i] = place / standing
            if loose or math.isnan(step):
                slips[0, k, i] = slips[1, k, i] = 0.0
            else:
                slips[0, k, i] += step - numbers[FAST_SHARE] * slips[0, k, i]
                slips[1, k, i] += (step if creeps else 0.0) - numbers[SLOW_SHARE] * slips[1, k, i]
            fast += slips[0, k, i] ** 2
            slow += slips[1, k, i] ** 2
        fast, slow = math.sqrt(fast), math.sqrt(slow)
        slides = fast > farthest[k] or slow <= numbers[CREEP_DISTANCE]
        motion[k] = fast if slides else slow
        allowed[k] = farthest[k] if slides else numbers[CREEP_DISTANCE]
        moves = motion[k] > allowed[k] and measured[k] > missing[k]
        if k >= 2 and motion[1] > 0.5 * farthest[1]:
            # The feet, which its place is measured against, move themselves.
            moves = False
            for i in range(3):
                slips[1, k, i] = 0.0
        if moves and not told[SLIPS, k]:
            told[SLIPS, k] = True
            slipping = 0 if k == 1 and measured[0] < measured[1] else k
            motion[slipping], allowed[slipping] = motion[k], allowed[k]
            found = 4 * SLIPS + slipping
        elif fast < 0.5 * farthest[k]:
            told[SLIPS, k] = False
        if moves:
            # It may creep on from here: that is another slip.
            for i in range(3):
                slips[1, k, i] = 0.0
    return found


@compiled
def place_against(
    watched: Flags,
    positions: Matrix,
    rotations: Matrix,
    k: int,
    i: int,
    x: float,
    y: float,
    z: float,
) -> tuple[float, float]:
    """Return component i of an end effector's place in the frames of the watched soles, summed up.

    And that of a motion (x, y, z) in the frame of the base.
    """
    place = moved = 0.0
    for foot in range(watched.shape[0]):
        if watched[foot]:
            for j in range(3):
                place += rotations[foot, j, i] * (positions[k, j] - positions[foot, j])
            moved += rotations[foot, 0, i] * x
            moved += rotations[foot, 1, i] * y
            moved += rotations[foot, 2, i] * z
    return place, moved


@compiled
def force_along(force: Vector, tare: Vector, normal: Vector) -> float:
    """Return how much of a force (3,) beside its tare is along the surface [N]."""
    square = out = 0.0
    for i in range(3):
        out += (force[i] - tare[i]) * normal[i]
        square += (force[i] - tare[i]) ** 2
    return math.sqrt(max(square - out * out, 0.0))


@compiled
def roll(
    rotations: Matrix,
    standing_rotations: Matrix,
    normals: Matrix,
    sole: int,
    k: int,
    radius: float,
    turned: Matrix,
) -> tuple[float, float, float]:
    """Return by how much the centre of a ball that sticks moved since the last step.

    It is dw x (r n) in the frame of the base [m], for the turn dw of the ball against a sole.

    Args:
        rotations: (4, 3, 3) base_from_effector.
        standing_rotations: (4, 3, 3) world_from_effector of what stands.
        normals: (4, 3) of the surfaces, in the world.
        sole: The foot.
        k: The hand.
        radius: [m]
        turned: (3, 3) sole_from_effector of the last step; becomes that of this one.
    """
    # All in the frame of the sole: n, then twice dw from the difference of two near rotations.
    nx = ny = nz = 0.0
    ax = ay = az = 0.0
    for j in range(3):
        nx += standing_rotations[sole, j, 0] * normals[k, j]
        ny += standing_rotations[sole, j, 1] * normals[k, j]
        nz += standing_rotations[sole, j, 2] * normals[k, j]
    for column in range(3):
        now0 = now1 = now2 = 0.0
        for j in range(3):
            now0 += rotations[sole, j, 0] * rotations[k, j, column]
            now1 += rotations[sole, j, 1] * rotations[k, j, column]
            now2 += rotations[sole, j, 2] * rotations[k, j, column]
        was0, was1, was2 = turned[0, column], turned[1, column], turned[2, column]
        ax += was1 * now2 - was2 * now1
        ay += was2 * now0 - was0 * now2
        az += was0 * now1 - was1 * now0
        turned[0, column], turned[1, column], turned[2, column] = now0, now1, now2
    if math.isnan(ax + ay + az):
        return 0.0, 0.0, 0.0
    scale = 0.5 * radius
    x = scale * (ay * nz - az * ny)
    y = scale * (az * nx - ax * nz)
    z = scale * (ax * ny - ay * nx)
    return (
        rotations[sole, 0, 0] * x + rotations[sole, 0, 1] * y + rotations[sole, 0, 2] * z,
        rotations[sole, 1, 0] * x + rotations[sole, 1, 1] * y + rotations[sole, 1, 2] * z,
        rotations[sole, 2, 0] * x + rotations[sole, 2, 1] * y + rotations[sole, 2, 2] * z,
    )
