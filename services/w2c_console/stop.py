"""Stop: two ways to the robot, whichever answers first.

The robot's own socket comes first: it needs neither the router nor any other process. The router
follows when the first way fails, or has not answered within half a second. The driver holds by
itself; the controller is told too, so that it does not fight the driver, but the robot's word alone
counts as an acknowledgement.
"""

import queue
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Literal, Protocol

import msgspec

from w2c import topics
from w2c.bus import Bus
from w2c.config import ServiceConfig
from w2c.messages import StopReply, StopRequest

PATIENCE_S = 0.5
"""How long one way may be silent before the next is tried as well [s]"""
DEADLINE_S = 2.5
"""How long the operator waits for the verdict [s]"""
DIAL_S = 2.0
"""Less than the deadline, so that its failure is told by its cause [s]"""
SETTLE_S = 0.2
"""How long the controller's answer may lag behind the robot's to be told along with it [s]"""

Receiver = Literal["robot", "controller"]


class StopLine(Protocol):
    """One way to the robot."""

    @property
    def name(self) -> str:
        """What the operator reads."""

    def stop_robot(self, request: StopRequest, timeout_s: float) -> StopReply:
        """Tell the driver to hold. Raises W2CError."""

    def stop_controller(self, request: StopRequest, timeout_s: float) -> StopReply:
        """Tell the controller to hold. Raises W2CError."""


class StopOutcome(msgspec.Struct, frozen=True):
    """What became of a stop, for the page."""

    acknowledged: bool
    """The robot said that it holds. Nothing else makes this true."""
    mode: str = ""
    """The driver's mode after the request"""
    stamp: str = ""
    """Robot time of the acknowledgement [ns]"""
    line: str = ""
    """The way that worked"""
    controller: str = "no answer yet"
    """acknowledged, or why not"""
    failures: list[str] = []
    seconds: float = 0.0
    """From the request to the acknowledgement, or to giving up [s]"""
    time_ms: int = 0
    """Wall clock [ms since 1970]"""


@dataclass(frozen=True)
class _Answer:
    line: str
    receiver: Receiver
    reply: StopReply | None
    problem: str = ""


@dataclass
class _Race:
    """What was answered so far."""

    robot: _Answer | None = None
    controller: str = "no answer yet"
    failures: list[str] = field(default_factory=list)
    waiting_for_robot: int = 0

    def take(self, answer: _Answer) -> None:
        """Count one answer."""
        if answer.receiver == "controller":
            if answer.reply is not None:
                self.controller = "acknowledged"
            elif self.controller != "acknowledged":
                self.controller = answer.problem
            return
        self.waiting_for_robot -= 1
        if answer.reply is None:
            self.failures.append(f"{answer.line}: {answer.problem}")
        elif answer.reply.mode == "tracking":
            self.failures.append(f"{answer.line}: answered, but the robot is still tracking")
        elif self.robot is None:
            self.robot = answer


def deliver_stop(
    lines: Sequence[StopLine],
    reason: str,
    *,
    patience_s: float = PATIENCE_S,
    deadline_s: float = DEADLINE_S,
    settle_s: float = SETTLE_S,
) -> StopOutcome:
    """Try every way until the robot acknowledges. Never raises: the operator gets a verdict."""
    request = StopRequest(reason=reason)
    answers: queue.Queue[_Answer] = queue.Queue()
    race = _Race()
    started = time.monotonic()
    deadline = started + deadline_s
    for index, line in enumerate(lines):
        _start(line, request, answers, deadline - time.monotonic())
        race.waiting_for_robot += 1
        last = index == len(lines) - 1
        until = deadline if last else min(deadline, time.monotonic() + patience_s)
        _listen(race, answers, until, lambda: race.robot is not None or not race.waiting_for_robot)
        if race.robot is not None:
            break
    seconds = time.monotonic() - started
    if race.robot is not None and race.controller != "acknowledged":
        settle = time.monotonic() + settle_s
        _listen(race, answers, settle, lambda: race.controller == "acknowledged")
    reply = race.robot.reply if race.robot else None
    if race.robot is None and race.waiting_for_robot:
        race.failures.append(f"no answer from the robot within {deadline_s:g} s")
    return StopOutcome(
        acknowledged=reply is not None,
        mode=reply.mode if reply else "",
        stamp=str(reply.stamp_ns) if reply else "",
        line=race.robot.line if race.robot else "",
        controller=race.controller,
        failures=race.failures,
        seconds=seconds,
        time_ms=time.time_ns() // 1_000_000,
    )


def _listen(
    race: _Race, answers: "queue.Queue[_Answer]", until: float, done: Callable[[], bool]
) -> None:
    """Take answers until `done` or the monotonic time `until` [s]."""
    while not done():
        remaining = until - time.monotonic()
        if remaining <= 0:
            return
        try:
            race.take(answers.get(timeout=remaining))
        except queue.Empty:
            return


def _start(
    line: StopLine, request: StopRequest, answers: "queue.Queue[_Answer]", timeout_s: float
) -> None:
    """Ask robot and controller at once, each on its own thread: one that hangs delays nobody."""

    def ask(receiver: Receiver, call: Callable[[StopRequest, float], StopReply]) -> None:
        try:
            answer = _Answer(line.name, receiver, call(request, timeout_s))
        except Exception as error:  # whatever went wrong, the operator must read it
            answer = _Answer(line.name, receiver, None, str(error) or type(error).__name__)
        answers.put(answer)

    for receiver, call in (("robot", line.stop_robot), ("controller", line.stop_controller)):
        threading.Thread(
            target=ask, args=(receiver, call), name=f"stop-{receiver}", daemon=True
        ).start()


class BusLine:
    """The console's own connection: through the router."""

    name = "router"

    def __init__(self, bus: Bus) -> None:
        self._bus = bus

    def stop_robot(self, request: StopRequest, timeout_s: float) -> StopReply:
        """Tell the driver to hold."""
        return self._bus.call(topics.ROBOT_STOP, request, timeout_s=timeout_s).message

    def stop_controller(self, request: StopRequest, timeout_s: float) -> StopReply:
        """Tell the controller to hold."""
        return self._bus.call(topics.CONTROLLER_STOP, request, timeout_s=timeout_s).message


class DialledLine:
    """The robot's own socket, dialled at the first stop and kept; dialled again after a failure."""

    name = "robot endpoint"

    def __init__(self, dial: Callable[[], Bus]) -> None:
        self._dial = dial
        self._lock = threading.Lock()
        self._bus: Bus | None = None

    def stop_robot(self, request: StopRequest, timeout_s: float) -> StopReply:
        """Tell the driver to hold."""
        bus = self._connected()
        try:
            return bus.call(topics.ROBOT_STOP, request, timeout_s=timeout_s).message
        except Exception:
            self._drop(bus)
            raise

    def stop_controller(self, request: StopRequest, timeout_s: float) -> StopReply:
        """Tell the controller to hold; it is a client of the same socket."""
        return self._connected().call(topics.CONTROLLER_STOP, request, timeout_s=timeout_s).message

    def close(self) -> None:
        """Close the connection, if there is one."""
        with self._lock:
            bus, self._bus = self._bus, None
        if bus is not None:
            bus.close()

    def _connected(self) -> Bus:
        with self._lock:
            if self._bus is None:
                self._bus = self._dial()
            return self._bus

    def _drop(self, bus: Bus) -> None:
        """Forget a connection that failed; the next stop dials afresh."""
        with self._lock:
            if self._bus is bus:
                self._bus = None
        bus.close()


def dial_robot(config: ServiceConfig) -> Callable[[], Bus]:
    """Return how to open a session to the robot's own endpoint."""

    def dial() -> Bus:
        from w2c.bus.zenoh_bus import connect

        quick = msgspec.structs.replace(
            config, connect_timeout=DIAL_S, instance=f"console-{config.instance}"
        )
        # Not "console": of two connections with one name, one that ends looks like both.
        return connect(quick, "operator", [config.robot_endpoint])

    return dial
