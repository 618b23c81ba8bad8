"""Whether contacts hold: lost, slipping and overloaded ones, from measured forces and angles.

A contact is lost when it shall carry weight and carries none; how one slips is in `slips`.
"""

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
from w2c_controller.switching.slips import (
    LOST,
    LOST_TIME,
    NOTHING,
    OVERLOAD_FORCE,
    OVERLOAD_TIME,
    OVERLOADED,
    PERIOD,
    SLIPS,
    follow_contacts,
)

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

CAUSES: Final[tuple[SafetyCause, ...]] = ("contact_lost", "contact_slips", "hand_overload")


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
        # In the order of the indices in `slips`.
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
        self._memory = (
            self._radii,
            self._wanted,
            self._missing,
            self._farthest,
            self._numbers,
            self._timers,
            self._places,
            self._turned,
            self._slips,
            self._told,
            self._measured,
            self._motion,
            self._allowed,
        )

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
        code = _look(
            self._watched,
            state.wrenches,
            measured.feet,
            measured.hands,
            measured.positions,
            measured.rotations,
            state.target_rotations,
            feelers.normals,
            feelers.tares,
            *self._memory,
        )
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
def _look(
    watched: Flags,
    wrenches: Matrix,
    feet: Matrix,
    hands: Matrix,
    positions: Matrix,
    rotations: Matrix,
    standing_rotations: Matrix,
    normals: Matrix,
    tares: Matrix,
    radii: Vector,
    wanted: Vector,
    missing: Vector,
    farthest: Vector,
    numbers: Vector,
    timers: Matrix,
    places: Matrix,
    turned: Matrix,
    slips: Matrix,
    told: Flags,
    measured: Vector,
    motion: Vector,
    allowed: Vector,
) -> int:
    """Weigh all contacts and follow where they are; returns 4 trouble + effector, or -1."""
    heavy = _weigh(
        watched,
        wrenches,
        feet,
        hands,
        normals,
        tares,
        wanted,
        missing,
        numbers,
        timers,
        told,
        measured,
    )
    slipping = follow_contacts(
        watched,
        wrenches,
        hands,
        positions,
        rotations,
        standing_rotations,
        normals,
        tares,
        radii,
        missing,
        farthest,
        numbers,
        places,
        turned,
        slips,
        told,
        measured,
        motion,
        allowed,
    )
    return slipping if heavy == NOTHING else heavy


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
    lost_time, dt = numbers[LOST_TIME], numbers[PERIOD]
    overload_force, overload_time = numbers[OVERLOAD_FORCE], numbers[OVERLOAD_TIME]
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
        # The more weight a hand misses, the sooner the robot falls.
        haste = wrenches[k, 2] / wanted[k] if k >= 2 else 1.0
        timers[0, k] = timers[0, k] + haste * dt if no_ground else 0.0
        timers[1, k] = timers[1, k] + dt if k >= 2 and force > overload_force else 0.0
        lost, overloaded = timers[0, k] > lost_time, timers[1, k] > overload_time
        if lost and not told[LOST, k]:
            found = 4 * LOST + k
        elif overloaded and not told[OVERLOADED, k]:
            found = 4 * OVERLOADED + k
        told[LOST, k], told[OVERLOADED, k] = lost, overloaded
    return found
