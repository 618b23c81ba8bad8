"""What is checked of each state before anything is computed from it; of commands: `restraint`.

All readings of a state stand in one vector. One compiled pass over it finds what is not finite,
what is beyond its limits for too long, and whether anything changes at all. Measurements are used
once in four ticks, and looked at whenever they are used.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pinocchio as pin

from w2c.messages import RobotDescription, RobotState
from w2c.messages.control import SafetyCause
from w2c_controller.compiled import compiled
from w2c_controller.parameters import EFFECTORS, HANDS, GuardLimits
from w2c_controller.safety.hazards import Hazard
from w2c_controller.sensing.loads import Measured

Vector = npt.NDArray[np.float64]
Counts = npt.NDArray[np.int64]

NOT_FINITE, BEYOND, FROZEN = 1, 2, 4
"""Bits of what `scan` finds."""
FROZEN_COMMAND = 1e-3
"""Readings may stay the same, bit by bit, while the command moves by less than this [rad]."""
SENSE_EVERY = 4
"""Ticks between two looks at the measurements: 125 Hz, well above the 10 Hz of their filters."""
JOINT_CHANNELS: tuple[tuple[SafetyCause, str], ...] = (
    ("position_limit", "rad"),
    ("velocity_limit", "rad/s"),
    ("torque_limit", "Nm"),
    ("not_following", "rad"),
)
"""Blocks of n readings, in this order; then 12 of the soles and 6 of the left wrist."""


@compiled
def scan(
    reading: Vector,
    previous: Vector,
    lower: Vector,
    upper: Vector,
    patience: Counts,
    beyond: Counts,
    command: Vector,
    reference: Vector,
    found: Counts,
) -> int:
    """Look at the readings of one tick. Returns bits; `found` says where.

    Args:
        reading: (m,) as in `JOINT_CHANNELS`; the block of following errors is filled here.
        previous: (m,) of the last tick; replaced by these.
        lower: (m,)
        upper: (m,)
        patience: (m,) scans beyond a limit that are too many.
        beyond: (m,) scans in a row that each reading was beyond; updated.
        command: (n,) in force.
        reference: (n,) command in force when a reading last changed; updated.
        found: (3,) index of a reading that is not finite, of one beyond, scans without a change;
            [2] is updated from its last value.
    """
    n = command.shape[0]
    bits = 0
    changed = False
    for i in range(reading.shape[0]):
        following = 3 * n <= i < 4 * n
        if following:
            reading[i] = command[i - 3 * n] - reading[i - 3 * n]
        value = reading[i]
        if not np.isfinite(value):
            bits |= NOT_FINITE
            found[0] = i
        elif value < lower[i] or value > upper[i]:
            beyond[i] += 1
            if beyond[i] >= patience[i]:
                bits |= BEYOND
                found[1] = i
        else:
            beyond[i] = 0
        if not following and value != previous[i]:
            changed = True
        previous[i] = value
    if changed:
        found[2] = 0
        for i in range(n):
            reference[i] = command[i]
        return bits
    found[2] += 1
    for i in range(n):
        if abs(command[i] - reference[i]) > FROZEN_COMMAND:
            bits |= FROZEN
    return bits


@dataclass(frozen=True)
class JointLimits:
    """Of all joints on the bus, in its order; each (n,)."""

    lower: Vector
    """[rad]"""
    upper: Vector
    velocity: Vector
    """[rad/s]"""
    effort: Vector
    """[Nm]"""


def joint_limits(description: RobotDescription) -> JointLimits:
    """Return what the robot's own description allows."""
    model = pin.buildModelFromXML(description.urdf, pin.JointModelFreeFlyer())
    joints = [model.joints[model.getJointId(joint.name)] for joint in description.joints]
    rows, velocities = [joint.idx_q for joint in joints], [joint.idx_v for joint in joints]
    return JointLimits(
        lower=model.lowerPositionLimit[rows].copy(),
        upper=model.upperPositionLimit[rows].copy(),
        velocity=model.velocityLimit[velocities].copy(),
        effort=np.array([joint.effort_limit for joint in description.joints]),
    )


NOTHING: Sequence[Hazard] = ()


class Guards:
    """Looks at states, loads and solutions. Remembers enough to tell a spike from a fault."""

    def __init__(
        self, description: RobotDescription, joints: JointLimits, limits: GuardLimits, dt: float
    ) -> None:
        self._names = [joint.name for joint in description.joints]
        self._limits = limits
        n = self._n = len(self._names)
        size = len(JOINT_CHANNELS) * n + 18
        self._reading = np.zeros(size)
        self._previous = np.zeros(size)
        self._command = np.zeros(n)
        self._reference = np.zeros(n)
        self._beyond = np.zeros(size, dtype=np.int64)
        self._found = np.zeros(3, dtype=np.int64)
        self._lower, self._upper = np.full(size, -np.inf), np.full(size, np.inf)
        self._patience = np.ones(size, dtype=np.int64)
        margin, follow = limits.position_margin, np.full(n, limits.following_error)
        blocks = (
            (joints.lower - margin, joints.upper + margin, limits.position_time),
            (-joints.velocity, joints.velocity, limits.velocity_time),
            (-limits.torque_factor * joints.effort, limits.torque_factor * joints.effort,
             limits.torque_time),
            (-follow, follow, limits.following_time),
        )  # fmt: skip
        for k, (low, high, time) in enumerate(blocks):
            block = slice(k * n, (k + 1) * n)
            self._lower[block], self._upper[block] = low, high
            self._patience[block] = max(1, round(time / (SENSE_EVERY * dt)))
        self._frozen_scans = limits.frozen_time / (SENSE_EVERY * dt)
        self._refused_ticks = round(limits.refused_time / dt)
        self._overload_time, self._overloaded = limits.hand_time, np.zeros(2)
        self._answers = 0
        self._failures = 0
        self._dt = dt
        self._bind()

    def _bind(self) -> None:
        """Keep views of the blocks: slicing at each tick costs more than copying."""
        n, reading = self._n, self._reading
        self._position, self._velocity = reading[:n], reading[n : 2 * n]
        self._torque = reading[2 * n : 3 * n]
        self._soles, self._wrist = reading[4 * n : 4 * n + 12], reading[4 * n + 12 :]

    def inspect(self, state: RobotState, *, used: bool) -> Sequence[Hazard]:
        """Return what is wrong with a state; nearly always nothing.

        Args:
            state: Of this tick.
            used: Whether its measurements are: those that are not are not looked at.
        """
        self._answers = self._answers + 1 if state.mode == "holding" else 0
        if not used:
            return NOTHING
        self._position[:] = state.position
        self._velocity[:] = state.velocity
        self._torque[:] = state.torque
        self._soles[:] = state.sole_wrenches.ravel()
        self._wrist[:] = state.left_wrist_wrench
        self._command[:] = state.command
        bits = scan(
            self._reading, self._previous, self._lower, self._upper, self._patience,
            self._beyond, self._command, self._reference, self._found,
        )  # fmt: skip
        if bits == 0 and self._answers < self._refused_ticks:
            return NOTHING
        return self._describe(bits)

    def inspect_loads(self, measured: Measured, elapsed: float) -> Hazard | None:
        """Return which hand bears too much for too long.

        Args:
            measured: Filtered forces.
            elapsed: Since the last look [s].
        """
        limit = self._limits.hand_force
        for row, (x, y, z) in enumerate(measured.hands.tolist()):
            force = math.sqrt(x * x + y * y + z * z)
            if not force > limit:
                self._overloaded[row] = 0.0
                continue
            self._overloaded[row] += elapsed
            if self._overloaded[row] >= self._overload_time:
                hand = EFFECTORS[HANDS[row]]
                text = f"the {hand.replace('_', ' ')} bears {force:.0f} N, limit {limit:.0f} N"
                return Hazard("hand_overload", text, hand, force, limit, "N")
        return None

    def inspect_solution(self, solved: bool) -> Hazard | None:
        """Return a hazard once too many quadratic programs in a row had no solution."""
        if solved:
            self._failures = 0
            return None
        self._failures += 1
        limit = self._limits.failed_programs
        if self._failures < limit:
            return None
        text = f"no posture keeps the balance: {self._failures} programs in a row without solution"
        return Hazard("qp_failed", text, "", float(self._failures), float(limit), "programs")

    # --- words -----------------------------------------------------------------------------------
    def _describe(self, bits: int) -> list[Hazard]:
        hazards = []
        if bits & NOT_FINITE:
            subject = self._reading_name(int(self._found[0]))
            hazards.append(
                Hazard("sensor_not_finite", f"{subject} reads no number", subject, float("nan"))
            )
        if bits & BEYOND:
            hazards.append(self._excess(int(self._found[1])))
        still = int(self._found[2])
        if bits & FROZEN and still >= self._frozen_scans:
            seconds, limit = still * SENSE_EVERY * self._dt, self._limits.frozen_time
            text = f"no reading changed for {seconds:.2f} s although the command did"
            hazards.append(Hazard("sensor_frozen", text, "all sensors", seconds, limit, "s"))
        if self._answers >= self._refused_ticks:
            seconds, limit = self._answers * self._dt, self._limits.refused_time
            text = f"the driver took no command for {seconds:.2f} s"
            hazards.append(Hazard("command_not_taken", text, "driver", seconds, limit, "s"))
        return hazards

    def _excess(self, index: int) -> Hazard:
        """Return a limit excess: only joints have limits here."""
        cause, unit = JOINT_CHANNELS[index // self._n]
        name, value = self._names[index % self._n], float(self._reading[index])
        limit = float(self._lower[index] if value < 0.0 else self._upper[index])
        if cause == "position_limit":
            limit = float(self._lower[index] if value < self._lower[index] else self._upper[index])
        words = {
            "position_limit": "is at",
            "velocity_limit": "turns at",
            "torque_limit": "bears",
            "not_following": "is off its command by",
        }[cause]
        text = f"{name} {words} {value:.2f} {unit}, limit {limit:.2f}"
        return Hazard(cause, text, name, value, limit, unit)

    def _reading_name(self, index: int) -> str:
        """Return what a reading is of."""
        n = self._n
        if index < 3 * n:
            return f"{('position', 'velocity', 'torque')[index // n]} of {self._names[index % n]}"
        if index < 4 * n:
            return f"position of {self._names[index - 3 * n]}"
        if index < 4 * n + 6:
            return "left foot sensor"
        return "right foot sensor" if index < 4 * n + 12 else "left wrist sensor"
