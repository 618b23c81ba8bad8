"""The state of processes, robot, controller and recorder, as rows of the page."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np

from w2c import topics
from w2c.messages import (
    ControllerStatus,
    Health,
    Message,
    ProcessState,
    ProcessTable,
    RecorderStatus,
    RobotState,
    Target,
)
from w2c_console.page import (
    ContactRow,
    ControllerPanel,
    ProcessRow,
    RecorderPanel,
    RobotPanel,
    TargetPanel,
)

M_co = TypeVar("M_co", bound=Message, covariant=True)

END_EFFECTORS = ("left foot", "right foot", "left hand", "right hand")
PERIODS_UNTIL_STALE = 3.0
SHORTEST_LIMIT_S = 1.0
"""Below this a person sees a flicker, not a fault"""

_LEVELS = {
    "ready": "good",
    "configure": "busy",
    "starting": "busy",
    "drain": "busy",
    "restarting": "busy",
    "stopped": "absent",
}


@dataclass(frozen=True)
class Aged(Generic[M_co]):
    """A message and when it arrived, by the console's clock [ns]."""

    message: M_co
    arrived_ns: int

    def age_s(self, now_ns: int) -> float:
        """Return the time since it arrived [s]."""
        return (now_ns - self.arrived_ns) * 1e-9


def age_limit_s(topic: topics.Topic[Any]) -> float:
    """Return the age from which the newest message of a topic is old news [s]."""
    return max(PERIODS_UNTIL_STALE / topic.rate_hz, SHORTEST_LIMIT_S)


def robot_panel(state: Aged[RobotState] | None, now_ns: int) -> RobotPanel | None:
    """Return the driver's state."""
    if state is None:
        return None
    age = state.age_s(now_ns)
    return RobotPanel(
        age_s=age,
        stale=age > age_limit_s(topics.ROBOT_STATE),
        mode=state.message.mode,
        stamp=str(state.message.stamp_ns),
    )


def controller_panel(status: Aged[ControllerStatus] | None, now_ns: int) -> ControllerPanel | None:
    """Return the controller's state, with the load on each end effector."""
    if status is None:
        return None
    message, age = status.message, status.age_s(now_ns)
    desired = np.linalg.norm(message.desired_forces, axis=1)  # (4,)
    return ControllerPanel(
        age_s=age,
        stale=age > age_limit_s(topics.CONTROLLER_STATUS),
        phase=message.phase,
        message=message.message,
        goal_id=message.goal_id,
        end_effector=message.end_effector,
        task=message.task,
        distance=message.distance,
        solver_failures=message.solver_failures,
        contacts=[
            ContactRow(name, message.in_contact[i], float(message.loads[i]), float(desired[i]))
            for i, name in enumerate(END_EFFECTORS)
        ],
        lateness_us=message.lateness_us,
        tick_us=message.tick_us,
    )


def recorder_panel(status: Aged[RecorderStatus] | None, now_ns: int) -> RecorderPanel | None:
    """Return the recorder's state."""
    if status is None:
        return None
    message, age = status.message, status.age_s(now_ns)
    return RecorderPanel(
        age_s=age,
        stale=age > age_limit_s(topics.RECORDER_STATUS),
        recording=message.recording,
        path=message.path,
        messages=message.messages,
        bytes=message.bytes,
        lost=sum(message.lost.values()),
        error=message.error,
    )


def target_panel(target: Target | None) -> TargetPanel | None:
    """Return what is known of the current target."""
    if target is None:
        return None
    return TargetPanel(
        target_id=target.target_id,
        state=target.state,
        instruction=target.instruction,
        corrections=target.corrections,
        warning=target.warning,
    )


def process_rows(
    health: Mapping[tuple[str, str], Aged[Health]],
    table: Aged[ProcessTable] | None,
    alive: Iterable[tuple[str, str]],
    now_ns: int,
) -> list[ProcessRow]:
    """Return a row for every process that is known of, in the order they start.

    Args:
        health: the last report of each (service, instance).
        table: what the launcher says, if there is one.
        alive: (service, instance) of every process whose connection is seen.
        now_ns: clock of the console [ns].
    """
    present = set(alive)
    launched: dict[str, ProcessState] = {}
    if table is not None and table.age_s(now_ns) <= age_limit_s(topics.PROCESS_TABLE):
        launched = {state.name: state for state in table.message.processes}
    known = set(health) | present
    named = {service for service, _ in known}
    known |= {(name, "0") for name in (*topics.SERVICES, *launched) if name not in named}
    order = {name: index for index, name in enumerate(topics.SERVICES)}
    return [
        _process_row(key, health.get(key), launched.get(key[0]), key in present, now_ns)
        for key in sorted(known, key=lambda key: (order.get(key[0], len(order)), key))
        if key[0] != "operator"  # a command line comes and goes; it is no part of the system
    ]


def _process_row(
    key: tuple[str, str],
    report: Aged[Health] | None,
    launched: ProcessState | None,
    present: bool,
    now_ns: int,
) -> ProcessRow:
    phase, level, detail = _judge(report, launched, present, now_ns)
    counters = {} if report is None else report.message.counters
    late = sum(count for name, count in counters.items() if name.startswith("late"))
    fresh = report is not None and level not in ("bad", "absent")
    return ProcessRow(
        name=key[0],
        instance=key[1],
        phase=phase,
        level=level,
        age_s=None if report is None else report.age_s(now_ns),
        cpu_percent=report.message.cpu_percent if report and fresh else None,
        memory_mb=report.message.memory_mb if report and fresh else None,
        restarts=0 if launched is None else launched.restarts,
        lost=sum(counters.values()) - late,
        late=late,
        detail=detail,
    )


def _judge(
    report: Aged[Health] | None, launched: ProcessState | None, present: bool, now_ns: int
) -> tuple[str, str, str]:
    """Return phase, level and detail of a process from what three witnesses say.

    The launcher knows best of processes that do not run; the process itself of those that do. A
    connection that is gone outweighs the last report, which cannot know of it.
    """
    if launched is not None and launched.phase in ("restarting", "failed"):
        return launched.phase, _LEVELS.get(launched.phase, "bad"), launched.detail
    if report is None:
        phase = launched.phase if launched is not None else "connected" if present else "absent"
        level = "busy" if present else _LEVELS.get(phase, "absent")
        return phase, level, launched.detail if launched is not None else ""
    if not present:
        return "gone", "bad", "its connection is closed"
    if report.age_s(now_ns) > age_limit_s(topics.HEALTH):
        return "silent", "bad", f"no report for {report.age_s(now_ns):.0f} s"
    phase = report.message.phase
    return phase, _LEVELS.get(phase, "bad"), report.message.detail
