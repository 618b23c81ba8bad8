"""A recorded session as the machine behind a driver."""

import logging
from pathlib import Path

import msgspec
import numpy as np

from w2c.bus import Bus
from w2c.messages import Array, RobotDescription, RobotState
from w2c.messages.robot import DriverMode
from w2c_sim_robot.recorded.config import RecordedRobotConfig
from w2c_sim_robot.recorded.session import Session, read_session, unpack

log = logging.getLogger("w2c.robot")


class RecordedRobot:
    """Plays states at the pace at which they were recorded; see `w2c.driver.Machine`.

    Commands move nothing: the state reports the one in force, which is all that becomes of it.
    Stopped, and at the end, it stands still where it is. Where states are missing the last one
    stays.
    """

    def __init__(self, session: Session, *, lock_step: bool = False, repeat: bool = False) -> None:
        self.description: RobotDescription = msgspec.structs.replace(
            session.description, lock_step=lock_step
        )
        self._ticks = session.ticks
        self._rows = session.rows
        self._repeat = repeat
        self._row = 0
        self._played = self._ticks[0]
        """The recorded tick that it is at."""
        self._still = False
        self.tick = 0
        self.command: Array = unpack(self._rows[0])["command"].copy()

    def state(self, *, command_tick: int, mode: DriverMode) -> RobotState:
        """Return the recorded state, with a new stamp, and the command that is in force now."""
        arrays = unpack(self._rows[self._row])
        if self._still:
            arrays["velocity"] = np.zeros_like(arrays["velocity"])
            arrays["imu_angular_velocity"] = np.zeros(3)
        arrays["command"] = self.command
        return RobotState(
            stamp_ns=self.tick * self.description.period_ns,
            tick=self.tick,
            command_tick=command_tick,
            mode=mode,
            **arrays,
        )

    def step(self, command: Array, mode: DriverMode) -> None:
        """Go on by one tick, unless stopped."""
        self.tick += 1
        self.command = command
        at_end = self._played >= self._ticks[-1]
        self._still = mode == "stopped" or (at_end and not self._repeat)
        if self._still:
            return
        if at_end:
            self._row, self._played = 0, self._ticks[0]
            return
        self._played += 1
        if self._ticks[self._row + 1] <= self._played:
            self._row += 1

    def publish(self, bus: Bus) -> None:
        """Say nothing more: what else was recorded was said by others."""

    def close(self) -> None:
        """Nothing to let go of."""


def open_recorded_robot(config: RecordedRobotConfig) -> RecordedRobot:
    """Read the recording. Raises RecordingError as `read_session`."""
    session = read_session(Path(config.recording), start_s=config.start, duration_s=config.duration)
    period_s = session.description.period_ns * 1e-9
    length_s = (session.ticks[-1] - session.ticks[0]) * period_s
    log.info("%d states, %.1f s, of %s", len(session.ticks), length_s, config.recording)
    return RecordedRobot(session, lock_step=config.lock_step, repeat=config.repeat)
