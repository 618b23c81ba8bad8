"""A small robot behind a driver, for tests."""

from collections.abc import Callable, Sequence

import numpy as np

from support.recordings import raw_message
from w2c import topics
from w2c.bus import Bus, RawReceived
from w2c.messages import Array, CallTrace, JointInfo, LogRecord, RobotDescription, RobotState
from w2c.messages.robot import DriverMode

PERIOD_NS = 2_000_000

URDF = """
<robot name="two">
  <link name="a"/><link name="b"/><link name="c"/><link name="hand"/>
  <joint name="hip" type="revolute"><parent link="a"/><child link="b"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name="rail" type="prismatic"><parent link="b"/><child link="c"/>
    <limit lower="0" upper="0.5" effort="1" velocity="1"/></joint>
  <joint name="bolt" type="fixed"><parent link="c"/><child link="hand"/></joint>
</robot>
"""


def describe(*, lock_step: bool = False, urdf: str = URDF) -> RobotDescription:
    """Return the description of a robot with two joints."""
    return RobotDescription(
        urdf=urdf,
        joints=[JointInfo(name=name, stiffness=1.0, effort_limit=1.0) for name in ("hip", "rail")],
        sole_frames=("a", "b"),
        hand_frames=("c", "hand"),
        hand_radius=(0.0, 0.05),
        camera_frame="hand",
        initial_position=np.array([0.0, 0.2]),
        period_ns=PERIOD_NS,
        lock_step=lock_step,
    )


def state_at(tick: int, *, command: Array | None = None, **changes: object) -> RobotState:
    """Return a state whose first angle is its tick times 1 mrad."""
    fields: dict[str, object] = {
        "stamp_ns": tick * PERIOD_NS,
        "tick": tick,
        "position": np.array([1e-3 * tick, 0.2]),
        "velocity": np.array([0.5, 0.0]),
        "torque": np.array([1.0, 2.0]),
        "sole_wrenches": np.arange(12.0).reshape(2, 6),
        "left_wrist_wrench": np.arange(6.0),
        "imu_orientation": np.array([0.0, 0.0, 0.0, 1.0]),
        "imu_angular_velocity": np.array([0.1, 0.2, 0.3]),
        "imu_linear_acceleration": np.array([0.0, 0.0, 9.81]),
        "command": np.array([0.0, 0.2]) if command is None else command,
        "command_tick": -1,
        "mode": "holding",
    }
    return RobotState(**{**fields, **changes})  # type: ignore[arg-type]


STATE_KEY = topics.ROBOT_STATE.key("test")


def description_trace(outcome: str = "ok") -> RawReceived:
    """Return the call of a controller that asked the robot to describe itself."""
    trace = CallTrace(
        service="robot",
        method="describe",
        instance="0",
        outcome=outcome,
        duration_ms=1.0,
        request=b"",
        reply=raw_message(describe(), "reply", sender="robot").payload,
    )
    return raw_message(trace, topics.TRACE.key("test", "controller"), sender="controller")


def raw_states(ticks: Sequence[int], *, key: str = STATE_KEY, boot: str = "boot"
               ) -> list[RawReceived]:  # fmt: skip
    return [
        raw_message(state_at(tick), key, number, boot_id=boot, sender="robot")
        for number, tick in enumerate(ticks)
    ]


def recorded_session(ticks: Sequence[int]) -> list[RawReceived]:
    """Return what a recorder hears of the robot: somebody asks what it is, and it is."""
    return [description_trace(), *raw_states(ticks)]


class ObedientMachine:
    """Is at once where it is told to be, and notes what it was told."""

    def __init__(self, description: RobotDescription) -> None:
        self.description = description
        self.tick = 0
        self.command = description.initial_position
        self.told: list[tuple[Array, DriverMode]] = []
        self.closed = False
        self.breaks_at = -1

    def state(self, *, command_tick: int, mode: DriverMode) -> RobotState:
        """Return a state at the commanded angles."""
        return state_at(
            self.tick,
            command=self.command,
            position=self.command,
            command_tick=command_tick,
            mode=mode,
        )

    def step(self, command: Array, mode: DriverMode) -> None:
        """Obey. Raises OSError at the tick where it was made to break."""
        if self.tick == self.breaks_at:
            raise OSError("the line is dead")
        self.tick += 1
        self.command = command
        self.told.append((command, mode))

    def publish(self, bus: Bus) -> None:
        """Say something of its own at every tenth tick."""
        if self.tick % 10 == 0:
            text = f"tick {self.tick}"
            bus.publish(topics.LOG, LogRecord(stamp_ns=0, level="info", logger="two", text=text))

    def close(self) -> None:
        """Note that it was let go of."""
        self.closed = True


class ScriptedClock:
    """A clock that jumps to each deadline and lets the test act there, in the loop's own thread."""

    def __init__(self, at_tick: Callable[[int], None]) -> None:
        self.now = 0
        """[ns]"""
        self._at_tick = at_tick
        self._sleeps = 0

    def now_ns(self) -> int:
        """Return the time [ns]."""
        return self.now

    def sleep_until(self, deadline_ns: int) -> None:
        """Jump there, where it is not past; the test acts."""
        self.now = max(self.now, deadline_ns)
        self._at_tick(self._sleeps)
        self._sleeps += 1
