"""Whether contacts hold: lost, slipping and overloaded ones, from measured forces and angles.

A contact is lost when it shall carry weight and carries none. It slips when it moves against the
feet: by the measured joint angles, a hand's place in the frames of the soles, and one sole's place
in the other's, do not change while all of them stick; nothing else of the world need be known. A
place follows slow changes (a ball rolls as its arm turns) with a time constant, so that what
counts is motion within about that time.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled
from w2c_controller.contact_parameters import Supervision
from w2c_controller.desired import DesiredState
from w2c_controller.feelers import Feelers
from w2c_controller.parameters import EFFECTORS
from w2c_controller.sensing import Measured

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

Trouble = Literal["lost", "slips", "overloaded"]
TROUBLES: Final[tuple[Trouble, ...]] = ("lost", "slips", "overloaded")
LOST: Final = 0
SLIPS: Final = 1
OVERLOADED: Final = 2
NOTHING: Final = -1


@dataclass(frozen=True)
class Finding:
    """A contact that does not hold."""

    trouble: Trouble
    effector: int
    value: float
    """Measured normal force [N], or motion against the feet [m]"""
    limit: float
    desired: float
    """Desired normal force [N]"""

    def text(self) -> str:
        """Return it in words."""
        name = EFFECTORS[self.effector].replace("_", " ")
        if self.trouble == "lost":
            return (
                f"the {name} lost its support: measured {self.value:.0f} N, "
                f"desired {self.desired:.0f} N"
            )
        if self.trouble == "slips":
            return f"the {name} slips: {self.value * 1e3:.1f} mm, limit {self.limit * 1e3:.1f} mm"
        return f"the {name} is overloaded: measured {self.value:.0f} N, limit {self.limit:.0f} N"


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
                supervision.slip_distance,
                min(dt / supervision.slip_window, 1.0),
                supervision.overload_force,
                supervision.overload_time,
                dt,
            ]
        )
        foot, hand = 0, 1
        self._wanted = np.array([supervision.lost_desired[k] for k in (foot, foot, hand, hand)])
        self._missing = np.array([supervision.lost_measured[k] for k in (foot, foot, hand, hand)])
        self.watched: Flags = np.zeros(4, dtype=np.bool_)
        """(4,)"""
        self._timers = np.zeros((2, 4))
        """(2, 4) how long a contact has been without ground, and overloaded [s]"""
        self._places = np.full((4, 3), np.nan)
        """(4, 3) where each was, against the feet [m]; NaN: to be taken anew"""
        self._measured = np.zeros(4)
        """(4,) of the last step: normal forces [N]"""
        self._motion = np.zeros(4)
        """(4,) of the last step [m]"""

    def watch(self, effectors: Iterable[int]) -> None:
        """Watch exactly these contacts from now on; what is watched already goes on."""
        wanted = set(effectors)
        feet_before = tuple(self.watched[:2])
        for k in range(4):
            if k in wanted and self.watched[k]:
                continue
            self.watched[k] = k in wanted
            self._timers[:, k] = 0.0
            self._places[k] = np.nan
        if tuple(self.watched[:2]) != feet_before:
            self._places[:] = np.nan

    def forget_motion(self) -> None:
        """Take the places of all contacts anew."""
        self._places[:] = np.nan

    def step(self, state: DesiredState, feelers: Feelers, measured: Measured) -> Finding | None:
        """Look at one measurement; returns the first contact that does not hold.

        A contact that was found is found again as long as it does not hold: forget it, or its
        motion.
        """
        code = _weigh(
            self.watched,
            state.wrenches,
            measured.feet,
            measured.hands,
            feelers.normals,
            feelers.tares,
            self._wanted,
            self._missing,
            self._numbers,
            self._timers,
            self._measured,
        )
        slipping = _follow(
            self.watched,
            measured.positions,
            measured.soles,
            self._numbers,
            self._places,
            self._measured,
            self._motion,
        )
        code = slipping if code == NOTHING else code
        if code == NOTHING:
            return None
        trouble, effector = divmod(code, 4)
        limits = (self._missing[effector], self._limits.slip_distance, self._limits.overload_force)
        value = self._motion[effector] if trouble == SLIPS else self._measured[effector]
        return Finding(
            trouble=TROUBLES[trouble],
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
        if found == NOTHING and timers[0, k] > lost_time:
            found = 4 * LOST + k
        if found == NOTHING and timers[1, k] > overload_time:
            found = 4 * OVERLOADED + k
    return found


@compiled
def _follow(
    watched: Flags,
    positions: Matrix,
    soles: Matrix,
    numbers: Vector,
    places: Matrix,
    measured: Vector,
    motion: Vector,
) -> int:
    """Update places and motions; returns 4 trouble + effector, or -1.

    Of two feet that move against each other, the one that carries less is the one that slips.
    """
    slip_distance, share = numbers[1], numbers[2]
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
        if found == NOTHING and motion[k] > slip_distance:
            slipping = 0 if k == 1 and measured[0] < measured[1] else k
            motion[slipping] = motion[k]
            found = 4 * SLIPS + slipping
    return found
