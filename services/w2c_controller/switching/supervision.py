"""Whether contacts hold: lost, slipping and overloaded ones, from measured forces and angles.

A contact is lost when it shall carry weight and carries none. It slips when it moves against the
feet: by the measured joint angles, a hand's place in the frames of the soles, and one sole's place
in the other's, do not change while all of them stick; nothing else of the world need be known. The
centre of a ball that sticks moves nevertheless where the ball turns: by w x (r n), as it rolls.
That is no slip, and is taken off. What counts is motion within about a time constant: fast slips
of all; and slow ones of hands, which a position-controlled arm draws over a surface that is more
slippery than assumed. Those count where the measured force is well within the assumed cone: within
it nothing slides but for a wrong assumption.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from w2c.messages.control import SafetyCause
from w2c_controller.compiled import compiled
from w2c_controller.parameters import EFFECTORS, FEET
from w2c_controller.safety.hazards import Hazard
from w2c_controller.seiko.desired import DesiredState
from w2c_controller.sensing.feelers import Feelers
from w2c_controller.sensing.loads import Measured
from w2c_controller.switching.contact_parameters import Supervision

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

LOST: Final = 0
SLIPS: Final = 1
OVERLOADED: Final = 2
CAUSES: Final[tuple[SafetyCause, ...]] = ("contact_lost", "contact_slips", "hand_overload")
NOTHING: Final = -1


@dataclass(frozen=True)
class Finding:
    """A contact that does not hold, or one that should not be."""

    cause: SafetyCause
    effector: int
    value: float
    """Measured force [N], or motion against the feet [m]"""
    limit: float
    desired: float = 0.0
    """Desired normal force [N]"""

    def text(self) -> str:
        """Return it in words."""
        name = EFFECTORS[self.effector].replace("_", " ")
        if self.cause == "contact_lost":
            return (
                f"the {name} lost its support: measured {self.value:.0f} N, "
                f"desired {self.desired:.0f} N"
            )
        if self.cause == "contact_slips":
            return f"the {name} slips: {self.value * 1e3:.1f} mm, limit {self.limit * 1e3:.1f} mm"
        what = "is overloaded" if self.cause == "hand_overload" else "touched something on its way"
        return f"the {name} {what}: measured {self.value:.0f} N, limit {self.limit:.0f} N"

    def hazard(self) -> Hazard:
        """Return it as it is reported."""
        return Hazard(
            cause=self.cause,
            text=self.text(),
            subject=EFFECTORS[self.effector],
            value=self.value,
            limit=self.limit,
            unit="m" if self.cause == "contact_slips" else "N",
        )


class ContactWatch:
    """Watches the contacts that were found to carry, each from then on."""

    def __init__(
        self, supervision: Supervision, friction: float, radii: tuple[float, float], dt: float
    ) -> None:
        """Watch nothing yet.

        Args:
            supervision: Limits.
            friction: That is assumed.
            radii: Of the balls that are the hands, left and right; 0 = no ball [m].
            dt: Period of `step` [s].
        """
        self._limits = supervision
        self._numbers = np.array(
            [
                supervision.lost_time,
                min(dt / supervision.slip_window, 1.0),
                min(dt / supervision.creep_window, 1.0),
                supervision.overload_force,
                supervision.overload_time,
                dt,
                supervision.slip_load,
                supervision.creep_distance,
                supervision.creep_cone * friction,
            ]
        )
        foot, hand = 0, 1
        self._wanted = np.array([supervision.lost_desired[k] for k in (foot, foot, hand, hand)])
        self._missing = np.array([supervision.lost_measured[k] for k in (foot, foot, hand, hand)])
        self._farthest = np.array([supervision.slip_distance[k] for k in (foot, foot, hand, hand)])
        self.watches = [False] * 4
        """Which contacts are watched"""
        self._watched: Flags = np.zeros(4, dtype=np.bool_)
        """(4,) the same, for compiled code"""
        self._timers = np.zeros((2, 4))
        """(2, 4) how long a contact has been without ground, and overloaded [s]"""
        self._places = np.full((4, 3), np.nan)
        """(4, 3) where each was at the last step, against the feet [m]; NaN: to be taken anew"""
        self._slips = np.zeros((2, 4, 3))
        """(2, 4, 3) motion of late: fast, slow [m]"""
        self._turned = np.full((4, 3, 3), np.nan)
        """(4, 3, 3) how each stood in the frame of a sole at the last step"""
        self._radii = np.array([0.0, 0.0, *radii])
        self._told: Flags = np.zeros((3, 4), dtype=np.bool_)
        """(3, 4) what was found and is still so"""
        self._measured = np.zeros(4)
        """(4,) of the last step: normal forces [N]"""
        self._motion = np.zeros(4)
        """(4,) of the last step [m]"""
        self._allowed = np.zeros(4)
        """(4,) its limit [m]"""

    def set(self, effector: int, watched: bool) -> None:
        """Begin or end to watch a contact; it is watched as it was where that is no change."""
        if self.watches[effector] == watched:
            return
        self.watches[effector] = self._watched[effector] = watched
        self._timers[:, effector] = 0.0
        self._told[:, effector] = False
        self._places[effector] = self._turned[effector] = np.nan
        if effector in FEET:
            # Places are means over the soles that stand.
            self._places[:] = self._turned[:] = np.nan

    def step(self, state: DesiredState, feelers: Feelers, measured: Measured) -> Finding | None:
        """Look at one measurement; returns the first contact that began not to hold, if any."""
        code = _weigh(
            self._watched,
            state.wrenches,
            measured.feet,
            measured.hands,
            feelers.normals,
            feelers.tares,
            self._wanted,
            self._missing,
            self._numbers,
            self._timers,
            self._told,
            self._measured,
        )
        slipping = _follow(
            self._watched,
            state.wrenches,
            measured.hands,
            measured.positions,
            measured.rotations,
            state.target_rotations,
            feelers.normals,
            feelers.tares,
            self._radii,
            self._missing,
            self._farthest,
            self._numbers,
            self._places,
            self._turned,
            self._slips,
            self._told,
            self._measured,
            self._motion,
            self._allowed,
        )
        code = slipping if code == NOTHING else code
        if code == NOTHING:
            return None
        trouble, effector = divmod(int(code), 4)
        overload = self._limits.overload_force
        limits = (self._missing[effector], self._allowed[effector], overload)
        value = self._motion[effector] if trouble == SLIPS else self._measured[effector]
        return Finding(
            cause=CAUSES[trouble],
            effector=effector,
            value=float(value),
            limit=float(limits[trouble]),
            desired=float(state.wrenches[effector, 2]),
        )


@compiled
def _weigh(
    watched: Flags,
    wrenches: Matrix,
    feet: Matrix,
    hands: Matrix,
    normals: Matrix,
    tares: Matrix,
    wanted: Vector,
    missing: Vector,
    numbers: Vector,
    timers: Matrix,
    told: Flags,
    measured: Vector,
) -> int:
    """Update measured normal forces and timers; returns 4 trouble + effector, or -1."""
    lost_time, overload_force, overload_time, dt = numbers[0], numbers[3], numbers[4], numbers[5]
    found = NOTHING
    for k in range(4):
        if not watched[k]:
            continue
        force = 0.0
        for i in range(3):
            felt = feet[k, i] if k < 2 else hands[k - 2, i]
            force += normals[k, i] * (felt - tares[k, i])
        measured[k] = force
        no_ground = wrenches[k, 2] > wanted[k] and force < missing[k]
        timers[0, k] = timers[0, k] + dt if no_ground else 0.0
        timers[1, k] = timers[1, k] + dt if k >= 2 and force > overload_force else 0.0
        lost, overloaded = timers[0, k] > lost_time, timers[1, k] > overload_time
        if lost and not told[LOST, k]:
            found = 4 * LOST + k
        elif overloaded and not told[OVERLOADED, k]:
            found = 4 * OVERLOADED + k
        told[LOST, k], told[OVERLOADED, k] = lost, overloaded
    return found


@compiled
def _follow(
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
        loose = k >= 2 and (wrenches[k, 2] < numbers[6] or measured[k] < missing[k])
        sole = 0 if watched[0] else 1
        x = y = z = 0.0
        if radii[k] > 0.0:
            x, y, z = _roll(rotations, standing_rotations, normals, sole, k, radii[k], turned[k])
        creeps = k >= 2 and _along(hands[k - 2], tares[k], normals[k]) < numbers[8] * measured[k]
        fast = slow = 0.0
        for i in range(3):
            place, rolled = _place(watched[:feet], positions, rotations, k, i, x, y, z)
            step = (place - rolled) / standing - places[k, i]
            places[k, i] = place / standing
            if loose or math.isnan(step):
                slips[0, k, i] = slips[1, k, i] = 0.0
            else:
                slips[0, k, i] += step - numbers[1] * slips[0, k, i]
                slips[1, k, i] += (step if creeps else 0.0) - numbers[2] * slips[1, k, i]
            fast += slips[0, k, i] ** 2
            slow += slips[1, k, i] ** 2
        fast, slow = math.sqrt(fast), math.sqrt(slow)
        slides = fast > farthest[k] or slow <= numbers[7]
        motion[k] = fast if slides else slow
        allowed[k] = farthest[k] if slides else numbers[7]
        moves = motion[k] > allowed[k] and measured[k] > missing[k]
        if k >= 2 and motion[1] > 0.5 * farthest[1]:
            # The feet, which its place is measured against, move themselves.
            moves = False
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
def _place(
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
def _along(force: Vector, tare: Vector, normal: Vector) -> float:
    """Return how much of a force (3,) beside its tare is along the surface [N]."""
    square = out = 0.0
    for i in range(3):
        out += (force[i] - tare[i]) * normal[i]
        square += (force[i] - tare[i]) ** 2
    return math.sqrt(max(square - out * out, 0.0))


@compiled
def _roll(
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
