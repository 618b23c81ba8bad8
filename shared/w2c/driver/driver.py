"""A robot on the bus: state out, commands in, stop always.

Real time: the newest command wins, and what happens without one is the watchdog's affair. Lock
step: the state of tick k goes out, and time stands still until the command that answers k comes.
That state is sent again every second, because a controller that starts later has not seen it: a
controller gives a tick that it has answered before the same answer, without computing.
"""

import logging
import threading
import time
from collections.abc import Callable
from functools import partial
from typing import TypeVar

from w2c import service, topics
from w2c.bus import Bus, Input
from w2c.bus.interface import CallContext, Queue, Received
from w2c.clock import Clock
from w2c.driver.config import DriverConfig
from w2c.driver.limits import joint_limits
from w2c.driver.machine import Machine
from w2c.driver.meter import Meter
from w2c.driver.pacing import Pacer
from w2c.driver.watchdog import Watchdog
from w2c.errors import ConfigError
from w2c.messages import Empty, JointCommand, RobotStatistics, StopReply, StopRequest
from w2c.realtime import NOT_ASKED, ROBOT_PRIORITY, collector_off, real_time

C = TypeVar("C", bound=DriverConfig)

_POLL_S = 0.1
_REPEAT_AFTER_POLLS = 10
_STATISTICS_S = 0.5

log = logging.getLogger("w2c.robot")


class Driver:
    """A node: see the module."""

    def __init__(
        self,
        config: DriverConfig,
        bus: Bus,
        clock: Clock,
        make_machine: Callable[[], Machine],
        *,
        processor_ns: Callable[[], int] = time.thread_time_ns,
    ) -> None:
        """Prepare; nothing is done yet.

        Args:
            config: of the loop.
            bus: the robot's own hub.
            clock: of the loop.
            make_machine: makes the machine when the driver is configured.
            processor_ns: processor time of the calling thread [ns].
        """
        self._config = config
        self._bus = bus
        self._clock = clock
        self._make_machine = make_machine
        self._processor_ns = processor_ns
        # Held for microseconds: by the loop for each command, by the handlers of stop and resume.
        self._lock = threading.Lock()
        self._command_input: tuple[Input, ...] = ()
        self._pacer: Pacer | None = None
        self._granted = NOT_ASKED
        self._said: RobotStatistics | None = None
        self._machine: Machine | None = None

    @property
    def machine(self) -> Machine:
        """Return the machine. Raises ConfigError before `configure`."""
        if self._machine is None:
            raise ConfigError("the driver has no machine yet: it was not configured")
        return self._machine

    @property
    def detail(self) -> str:
        """What people should know of this process: what was not granted, and how it keeps time."""
        said = self._said
        if said is None:
            return self._granted.trouble
        speed = f"{said.real_time_factor:.1f}x real time"
        if self._pacer is not None:
            speed += f", runs at {said.pace:.2f}x, {said.late_periods} late periods"
        return "; ".join(filter(None, (self._granted.trouble, speed)))

    def configure(self) -> None:
        """Make the machine, and answer who asks for it.

        Raises:
            W2CError: there is no machine, or it describes itself badly.
        """
        self._machine = machine = self._make_machine()
        description = machine.description
        command = machine.command
        if command.shape != (len(description.joints),):
            raise ConfigError(
                f"the machine's command has the shape {command.shape}, its description "
                f"{len(description.joints)} joints"
            )
        period_s = description.period_ns * 1e-9
        self._lock_step = description.lock_step
        self._period_ns = description.period_ns
        self._statistics_every = max(1, round(_STATISTICS_S / period_s))
        self.watchdog = Watchdog(
            command,
            joint_limits(description),
            period_s=period_s,
            timeout_ticks=max(1, round(self._config.watchdog_ms * 1e-3 / period_s)),
        )
        if self._lock_step:
            self._bus.use_lock_step()
            self._commands = self._bus.queue(topics.JOINT_COMMAND)
        else:
            self._newest_command = self._bus.latest(topics.JOINT_COMMAND)
        self._bus.serve(topics.DESCRIBE, lambda _request, _context: description)
        self._bus.serve(topics.ROBOT_STOP, self._stop)
        self._bus.serve(topics.ROBOT_RESUME, self._resume)

    def run(self, stop: threading.Event) -> None:
        """Live until `stop`."""
        self._meter = Meter(self._clock, self._period_ns, self._processor_ns)
        with collector_off():
            if self._lock_step:
                self._run_in_lock_step(stop, self._commands)
                return
            with real_time(ROBOT_PRIORITY, self._config.real_time) as self._granted:
                if self._granted.trouble:
                    log.warning("the loop may be late: %s", self._granted.trouble)
                self._run_in_real_time(stop)

    def close(self) -> None:
        """Say how well time was kept, and let go of the machine."""
        if self._pacer is not None:
            lateness = self._pacer.lateness_us()
            log.info("lateness %s", {key: round(value) for key, value in lateness.items()})
        if self._machine is not None:
            self._machine.close()

    def _run_in_real_time(self, stop: threading.Event) -> None:
        self._pacer = Pacer(self._clock, self._period_ns)
        self._publish()
        while not stop.is_set():
            if not self._pacer.wait():
                self._bus.count("late 20 ms")
            received = self._newest_command.take()
            if received is not None:
                self._offer(received)
            self._step()
            self._publish()

    def _run_in_lock_step(self, stop: threading.Event, commands: Queue[JointCommand]) -> None:
        while not stop.is_set():
            self._publish()
            if self._wait_for_answer(stop, commands):
                self._step()

    def _wait_for_answer(self, stop: threading.Event, commands: Queue[JointCommand]) -> bool:
        """Return True when this tick was answered, well or badly; False to publish it again."""
        tick = self.machine.tick
        for _ in range(_REPEAT_AFTER_POLLS):
            received = commands.receive(_POLL_S)
            while received is not None:
                if received.message.tick == tick:
                    self._offer(received)
                    return True
                self._bus.count("command of another tick")
                received = commands.receive(0.0)
            if stop.is_set():
                break
        return False

    def _offer(self, received: Received[JointCommand]) -> None:
        message = received.message
        with self._lock:
            refusal = self.watchdog.offer(
                message.position, answered_tick=message.tick, now_tick=self.machine.tick
            )
        if refusal is None:
            self._command_input = (received.as_input(),)
        else:
            self._bus.count(f"command refused: {refusal}")

    def _step(self) -> None:
        self._meter.begin()
        with self._lock:
            self.watchdog.check(self.machine.tick)
            command, mode = self.watchdog.command, self.watchdog.mode
        self.machine.step(command, mode)
        self._meter.end()

    def _publish(self) -> None:
        machine = self.machine
        with self._lock:
            mode, command_tick = self.watchdog.mode, self.watchdog.command_tick
        state = machine.state(command_tick=command_tick, mode=mode)
        self._bus.publish(topics.ROBOT_STATE, state, self._command_input)
        machine.publish(self._bus)
        if self._statistics_due(state.tick):
            self._said = self._statistics(state.tick)
            self._bus.publish(topics.ROBOT_STATISTICS, self._said)

    def _statistics_due(self, tick: int) -> bool:
        """Tell whether they are due: in lock step a state goes out again, they do not."""
        again = self._said is not None and self._said.tick == tick
        return tick > 0 and tick % self._statistics_every == 0 and not again

    def _statistics(self, tick: int) -> RobotStatistics:
        pace, factor = self._meter.read()
        lateness = {} if self._pacer is None else self._pacer.lateness_us()
        return RobotStatistics(
            stamp_ns=tick * self._period_ns,
            tick=tick,
            pace=pace,
            real_time_factor=factor,
            late_periods=0 if self._pacer is None else self._pacer.late,
            gaps_20ms=0 if self._pacer is None else self._pacer.gaps,
            lateness_p50_us=lateness.get("p50", 0.0),
            lateness_p99_us=lateness.get("p99", 0.0),
            lateness_max_us=lateness.get("max", 0.0),
            memory_locked=self._granted.memory_locked,
            real_time_priority=self._granted.priority,
        )

    def _stop(self, request: StopRequest, context: CallContext) -> StopReply:
        with self._lock:
            self.watchdog.stop()
        log.warning("stopped by %s: %s", context.caller, request.reason or "no reason given")
        return self._mode_reply()

    def _resume(self, _request: Empty, context: CallContext) -> StopReply:
        with self._lock:
            self.watchdog.resume()
        log.warning("resumed by %s", context.caller)
        return self._mode_reply()

    def _mode_reply(self) -> StopReply:
        return StopReply(mode=self.watchdog.mode, stamp_ns=self.machine.tick * self._period_ns)


def main(
    config_type: type[C],
    load_machine: Callable[[], Callable[[C], Machine]],
    arguments: list[str] | None,
    *,
    extra: str,
    verb: str = "robot",
) -> int:
    """Run the driver of a robot from its flags. Returns the exit status.

    Args:
        config_type: its flags.
        load_machine: imports what makes the machine, and with it the dependencies of the extra.
        arguments: without the program's name; None = those of the process.
        extra: that `load_machine` needs.
        verb: the word after `w2c` that starts it.
    """

    def load_node() -> Callable[[C, Bus, Clock], Driver]:
        make_machine = load_machine()
        return lambda config, bus, clock: Driver(config, bus, clock, partial(make_machine, config))

    return service.main(
        "robot", config_type, load_node, arguments, extra=extra, hub=True, verb=verb
    )
