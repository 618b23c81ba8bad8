"""Whether the robot takes the commands: the motion must not run ahead of it.

Where answers come too late, the driver refuses them and holds the last good one. A controller that
went on meanwhile would make the arm leap by all that was refused as soon as one is taken again.
"""

from typing import Final

import numpy as np

from w2c.messages import RobotState

FARTHEST_AHEAD: Final = 5
"""Commands that may be under way to the robot. At the speed of a hand in the air they are 2 mm; a
link as slow as this slows the motion down. On a busy machine two or three are under way."""


class Uptake:
    """Remembers which of the last ticks the motion went on at."""

    def __init__(self) -> None:
        self._ticks = np.full(FARTHEST_AHEAD, -1)
        self._oldest = 0

    def lags(self, state: RobotState) -> bool:
        """Return whether the robot has none of the last `FARTHEST_AHEAD` commands in force."""
        return bool(self._ticks[self._oldest] > state.command_tick)

    def went_on(self, tick: int) -> None:
        """Note that the motion went on in the answer to a tick."""
        self._ticks[self._oldest] = tick
        self._oldest = (self._oldest + 1) % FARTHEST_AHEAD
