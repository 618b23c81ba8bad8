"""What a recording tells of a robot: its description, and its states in memory."""

import logging
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from w2c import topics
from w2c.bus import decode_envelope
from w2c.bus.codec import validate
from w2c.errors import MessageError, RecordingError
from w2c.library import library
from w2c.messages import Array, CallTrace, RobotDescription, RobotState

LONGEST_S = 900.0
"""At 500 Hz, half a gigabyte."""

log = logging.getLogger("w2c.robot")


@dataclass(frozen=True)
class Session:
    """A part of one run of a robot."""

    description: RobotDescription
    ticks: list[int]
    """Of the states, ascending; some may be missing"""
    rows: list[Array]
    """Of the states: their arrays in one; see `unpack`"""


def pack(state: RobotState) -> Array:
    """Return the arrays of a state in one (4 n + 28,)."""
    return np.concatenate(
        [
            *(state.position, state.velocity, state.torque, state.command),
            *(state.sole_wrenches.reshape(-1), state.left_wrist_wrench, state.imu_orientation),
            *(state.imu_angular_velocity, state.imu_linear_acceleration),
        ]
    )


def unpack(row: Array) -> dict[str, Array]:
    """Return the arrays that were packed, by the names of the state's fields."""
    n = (len(row) - 28) // 4
    joints, rest = row[: 4 * n].reshape(4, n), row[4 * n :]
    return {
        "position": joints[0],
        "velocity": joints[1],
        "torque": joints[2],
        "command": joints[3],
        "sole_wrenches": rest[:12].reshape(2, 6),
        "left_wrist_wrench": rest[12:18],
        "imu_orientation": rest[18:22],
        "imu_angular_velocity": rest[22:25],
        "imu_linear_acceleration": rest[25:28],
    }


def read_session(path: Path, *, start_s: float = 0.0, duration_s: float = 0.0) -> Session:
    """Read a part of a recording.

    A file that ends in the middle, because its writer was killed, is read as far as it goes. Where
    the robot was started more than once, the first run is read.

    Args:
        path: of the MCAP file.
        start_s: since the first state [s].
        duration_s: 0 = to the end [s].

    Raises:
        RecordingError: there is no such file, or no robot is in it that could be played.
    """
    recording = library("recording")(path)
    description: RobotDescription | None = None
    run = _Run(path, round(start_s * 1e9), round(duration_s * 1e9))
    for recorded in recording.of(topics.ROBOT_STATE, topics.TRACE):
        message = recorded.message
        if isinstance(message, CallTrace):
            description = description or _described(message)
        else:
            run.add(message, recorded.key, recorded.envelope.boot_id)
        if run.complete and description is not None:
            break
    if recording.damage.reason:
        log.warning("%s %s; it is played as far as it goes", path, recording.damage.reason)
    run.check()
    if description is None:
        raise RecordingError(
            f"{path} holds no description of the robot: nobody asked for it while it was recorded. "
            "Record from before the controller starts, as `w2c up` does"
        )
    found = (len(run.rows[0]) - 28) // 4
    if found != len(description.joints):
        raise RecordingError(
            f"{path}: states of {found} joints, a description of {len(description.joints)}"
        )
    return Session(description=description, ticks=run.ticks, rows=run.rows)


@dataclass
class _Run:
    """Collects the states of the first run of one robot, from a time on and for a time [ns]."""

    path: Path
    start_ns: int
    duration_ns: int
    ticks: list[int] = field(default_factory=list)
    rows: list[Array] = field(default_factory=list)
    complete: bool = False
    _key: str = ""
    _boot_id: str = ""
    _first_ns: int = 0
    _last_ns: int = 0
    _started_anew: bool = False

    def add(self, state: RobotState, key: str, boot_id: str) -> None:
        """Take the next state. Raises RecordingError where it is another robot's, or too much."""
        if not self._key:
            self._key, self._boot_id, self._first_ns = key, boot_id, state.stamp_ns
        if key != self._key:
            raise RecordingError(f"{self.path} holds two robots: {self._key} and {key}")
        if boot_id != self._boot_id:
            if not self._started_anew:
                log.warning("the robot of %s started anew; its first run is played", self.path)
            self._started_anew = True
            return
        self._last_ns = state.stamp_ns
        since_ns = state.stamp_ns - self._first_ns - self.start_ns
        if self.duration_ns and since_ns > self.duration_ns:
            self.complete = True
        elif since_ns >= 0 and (not self.ticks or state.tick > self.ticks[-1]):
            if since_ns > LONGEST_S * 1e9:
                raise RecordingError(
                    f"{self.path}: more than {LONGEST_S:.0f} s do not fit into memory; "
                    "choose a part with --start and --duration"
                )
            self.ticks.append(state.tick)  # not what lock step sent twice
            self.rows.append(pack(state))

    def check(self) -> None:
        """Raise RecordingError where nothing was found."""
        if not self._key:
            raise RecordingError(
                f"{self.path} holds no states of a robot ({topics.ROBOT_STATE.key('*')}); "
                "`w2c recording info` tells what it holds"
            )
        if not self.rows:
            length_s = (self._last_ns - self._first_ns) * 1e-9
            raise RecordingError(
                f"{self.path}: no state from {self.start_ns * 1e-9:g} s on; its robot ran for "
                f"{length_s:.1f} s"
            )


def _described(trace: CallTrace) -> RobotDescription | None:
    """Return the description that a call got; None for other calls, and failed ones."""
    if (trace.service, trace.method, trace.outcome) != ("robot", topics.DESCRIBE.name, "ok"):
        return None
    try:
        return validate(decode_envelope(trace.reply).data, RobotDescription)
    except MessageError as error:
        log.warning("a description in the recording cannot be read: %s", error)
        return None
