"""Whether contacts hold: lost, slipping and overloaded ones, from measured forces and angles.

A contact is lost when it shall carry weight and carries none. It slips when it moves against the
feet: by the measured joint angles, a hand's place in the frames of the soles, and one sole's place
in the other's, do not change while all of them stick; nothing else of the world need be known. A
place follows slow changes (a ball rolls as its arm turns) with a time constant, so that what
counts is motion within about that time.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from w2c.messages.control import SafetyCause
from w2c_controller.compiled import compiled
from w2c_controller.contact_parameters import Supervision
from w2c_controller.desired import DesiredState
from w2c_controller.feelers import Feelers
from w2c_controller.parameters import EFFECTORS, FEET
from w2c_controller.safety import Hazard
from w2c_controller.sensing import Measured

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

    def __init__(self, supervision: Supervision, dt: float) -> None:
        """Watch nothing yet.

        Args:
            supervision: Limits.
            dt: Period of `step` [s].
        """
        self._limits = supervision
        self._numbers = np.array(
            [
                supervision.lost_time,
                min(dt / supervision.slip_window, 1.0),
                supervision.overload_force,
                supervision.overload_time,
                dt,
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
        """(4, 3) where each was, against the feet [m]; NaN: to be taken anew"""
        self._told: Flags = np.zeros((3, 4), dtype=np.bool_)
        """(3, 4) what was found and is still so"""
        self._measured = np.zeros(4)
        """(4,) of the last step: normal forces [N]"""
        self._motion = np.zeros(4)
        """(4,) of the last step [m]"""

    def set(self, effector: int, watched: bool) -> None:
        """Begin or end to watch a contact; it is watched as it was where that is no change."""
        if self.watches[effector] == watched:
            return
        self.watches[effector] = self._watched[effector] = watched
        self._timers[:, effector] = 0.0
        self._told[:, effector] = False
        self._places[effector] = np.nan
        if effector in FEET:
            # Places are means over the soles that stand.
            self._places[:] = np.nan

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
            measured.positions,
            measured.soles,
            self._missing,
            self._farthest,
            self._numbers,
            self._places,
            self._told,
            self._measured,
            self._motion,
        )
        code = slipping if code == NOTHING else code
        if code == NOTHING:
            return None
        trouble, effector = divmod(int(code), 4)
        overload = self._limits.overload_force
        limits = (self._missing[effector], self._farthest[effector], overload)
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
    lost_time, overload_force, overload_time, dt = numbers[0], numbers[2], numbers[3], numbers[4]
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
    positions: Matrix,
    soles: Matrix,
    missing: Vector,
    farthest: Vector,
    numbers: Vector,
    places: Matrix,
    told: Flags,
    measured: Vector,
    motion: Vector,
) -> int:
    """Update places and motions; returns 4 trouble + effector, or -1.

    What carries nothing does not slip. Of two feet that move against each other, the one that
    carries less is the one that slips.
    """
    share = numbers[1]
    found = NOTHING
    for k in range(1, 4):
        motion[k] = 0.0
        feet = 1 if k == 1 else 2
        standing = int(watched[0]) + int(watched[1]) * (feet - 1)
        if not watched[k] or standing == 0:
            continue
        square = 0.0
        for i in range(3):
            place = 0.0
            for foot in range(feet):
                if watched[foot]:
                    for j in range(3):
                        way = positions[k, j] - positions[foot, j]
                        place += soles[foot, j, i] * way / standing
            if math.isnan(places[k, i]):
                places[k, i] = place
            square += (place - places[k, i]) ** 2
            places[k, i] += share * (place - places[k, i])
        motion[k] = math.sqrt(square)
        moves = motion[k] > farthest[k] and measured[k] > missing[k]
        if k >= 2 and motion[1] > 0.5 * farthest[1]:
            # The feet, which its place is measured against, move themselves.
            moves = False
        if moves and not told[SLIPS, k]:
            told[SLIPS, k] = True
            slipping = 0 if k == 1 and measured[0] < measured[1] else k
            motion[slipping] = motion[k]
            found = 4 * SLIPS + slipping
        elif motion[k] < 0.5 * farthest[k]:
            told[SLIPS, k] = False
    return found
