"""What a driver needs of a robot."""

from typing import Protocol

from w2c.bus import Bus
from w2c.messages import Array, RobotDescription, RobotState
from w2c.messages.robot import DriverMode


class Machine(Protocol):
    """A robot, or what stands in for one. All but `close` is called by the driver's loop alone.

    Tick k is the k-th period since the machine was made; its state has the stamp k * period. In
    real time the driver paces the loop: `step` must return well within a period.
    """

    @property
    def description(self) -> RobotDescription:
        """Return what a controller must know. Constant; joint vectors are in its order."""

    @property
    def tick(self) -> int:
        """Return the number of steps so far."""

    @property
    def command(self) -> Array:
        """Return the joint command in force (n,) [rad]: before the first step, what holds it."""

    def state(self, *, command_tick: int, mode: DriverMode) -> RobotState:
        """Return what the sensors read at this tick.

        Args:
            command_tick: the tick that the command in force answers; -1 before the first.
            mode: of the driver. Both only to be passed on in the state.
        """

    def step(self, command: Array, mode: DriverMode) -> None:
        """Go on by one tick.

        Args:
            command: to be reached at the end of the tick (n,) [rad]. Checked by the watchdog:
                finite, of the right length, and near the one before. While holding or stopped it
                is the last one again.
            mode: for machines that can do more about a stop than to hold.

        Raises:
            W2CError: the machine is lost. The driver ends, and says why.
        """

    def publish(self, bus: Bus) -> None:
        """Publish what only this machine has to say. Called after each state; mostly nothing."""

    def close(self) -> None:
        """Let go of the machine. Called at the end in every case, by the thread of the process."""
