"""What the driver does with commands, and without them. No bus, no clock: robot ticks only."""

from typing import Literal

import numpy as np

from w2c.messages import Array
from w2c.messages.robot import DriverMode

Refusal = Literal["length", "not_finite", "jump", "old", "future", "stopped"]

_FASTEST_SWEEP_S = 0.75
"""A joint may cross its whole range in this time, no faster."""
_FORGIVEN_TICKS = 5
"""A command may make up for this many lost before it."""


class Watchdog:
    """Decides which joint command is in force.

    | mode | a good command | silence | stop | resume |
    |---|---|---|---|---|
    | holding | tracking | holding | stopped | holding |
    | tracking | tracking | holding, after the time-out | stopped | tracking |
    | stopped | refused | stopped | stopped | holding |

    A refused command changes nothing: the last good one is held. So whoever starts to command, at
    first or after a pause, has to begin near the command in force, which the robot's state tells.
    """

    def __init__(
        self, command: Array, limits: Array, *, period_s: float, timeout_ticks: int
    ) -> None:
        """Hold a first command.

        Args:
            command: the one in force from the start (n,) [rad].
            limits: lower and upper joint limits (n, 2) [rad].
            period_s: of a tick [s].
            timeout_ticks: how old the answered tick may be before the driver holds.
        """
        self._command = np.array(command, dtype=np.float64)
        self._largest_step = (limits[:, 1] - limits[:, 0]) * period_s / _FASTEST_SWEEP_S
        self._timeout_ticks = timeout_ticks
        self._command_tick = -1
        self._mode: DriverMode = "holding"

    @property
    def mode(self) -> DriverMode:
        """Return the mode."""
        return self._mode

    @property
    def command(self) -> Array:
        """Return the command in force (n,) [rad]."""
        return self._command

    @property
    def command_tick(self) -> int:
        """Return the tick that the command in force answers; -1 before the first."""
        return self._command_tick

    def offer(self, command: Array, *, answered_tick: int, now_tick: int) -> Refusal | None:
        """Take a command that answers the state of a tick. Returns why not, or None."""
        refusal = self._refusal(command, answered_tick, now_tick)
        if refusal is None:
            self._command = np.array(command, dtype=np.float64)
            self._command_tick = answered_tick
            self._mode = "tracking"
        return refusal

    def check(self, now_tick: int) -> None:
        """Hold if the last good command is too old."""
        if self._mode == "tracking" and now_tick - self._command_tick > self._timeout_ticks:
            self._mode = "holding"

    def stop(self) -> None:
        """Hold until resumed. Idempotent."""
        self._mode = "stopped"

    def resume(self) -> None:
        """Listen to commands again. Does nothing when not stopped."""
        if self._mode == "stopped":
            self._mode = "holding"

    def _refusal(self, command: Array, answered_tick: int, now_tick: int) -> Refusal | None:
        if self._mode == "stopped":
            return "stopped"
        if answered_tick > now_tick:
            return "future"
        too_old = now_tick - answered_tick > self._timeout_ticks
        if too_old or answered_tick <= self._command_tick:
            return "old"
        return self._bad_angles(command, answered_tick - self._command_tick)

    def _bad_angles(self, command: Array, ticks: int) -> Refusal | None:
        """Judge the angles of a command that comes some ticks after the one in force."""
        if command.shape != self._command.shape:
            return "length"
        if not np.isfinite(command).all():
            return "not_finite"
        allowed = min(ticks, _FORGIVEN_TICKS) * self._largest_step
        return "jump" if (np.abs(command - self._command) > allowed).any() else None
