"""What is done with each command before it is sent: slowed down, or refused as a fault."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled
from w2c_controller.safety.guards import JointLimits
from w2c_controller.safety.hazards import Hazard

Vector = npt.NDArray[np.float64]

SWEEP_TIME = 0.75
"""A joint may cross its whole range in this time, no faster: the driver refuses what does [s]."""
JUMP = 5.0
"""A command that asks for this many times as much is a fault; what asks for less comes later."""


@compiled
def slow_down(command: Vector, previous: Vector, largest_step: Vector) -> int:
    """Bring each joint of a command (n,) within (n,) of the last: it arrives some ticks later.

    Returns:
        The first joint whose command is not finite, or is a jump: then all stay; -1 = none.
    """
    for i in range(command.shape[0]):
        if not abs(command[i] - previous[i]) <= JUMP * largest_step[i]:
            return i
    for i in range(command.shape[0]):
        step = command[i] - previous[i]
        command[i] = previous[i] + min(max(step, -largest_step[i]), largest_step[i])
    return -1


class Restraint:
    """Keeps commands to what the driver takes."""

    def __init__(self, names: Sequence[str], joints: JointLimits, dt: float) -> None:
        """Take the limits from the joints' ranges.

        Args:
            names: Of the joints on the bus, in its order.
            joints: Limits of the same.
            dt: Period of commands [s].
        """
        self._names = names
        self._largest_step = (joints.upper - joints.lower) * dt / SWEEP_TIME

    def apply(self, command: Vector, previous: Vector) -> Hazard | None:
        """Slow a command (n,) down to what the driver takes after another one [rad].

        Returns:
            What is wrong with it, where it is no number or so far off that it must be a fault; it
            is not changed then.
        """
        at = slow_down(command, previous, self._largest_step)
        if at < 0:
            return None
        name = self._names[at]
        if not np.isfinite(command).all():
            text = f"the command of {name} is not finite"
            return Hazard("command_not_finite", text, name, float(command[at]), 0.0, "rad")
        step, limit = float(abs(command[at] - previous[at])), JUMP * float(self._largest_step[at])
        text = f"the command of {name} would jump by {step:.4f} rad in one tick, limit {limit:.4f}"
        return Hazard("command_jump", text, name, step, limit, "rad")
