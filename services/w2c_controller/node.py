"""The controller on the bus: states in, commands out, goals from threads of their own.

Real time: the newest state is answered; ticks that were missed are skipped, and the motion is
slower by them. Lock step: every state is answered once, and one that comes again gets the same
answer again. The loop only ticks and sends commands: what else is told goes through `Reports`.
"""

import logging
import sys
import threading
import time

from w2c import topics
from w2c.bus import Bus, Queue, Received
from w2c.clock import Clock
from w2c.errors import CallError, ConnectionFailedError, ControlError
from w2c.messages import (
    ControllerSnapshot,
    Empty,
    JointCommand,
    RobotDescription,
    RobotState,
)
from w2c.realtime import CONTROLLER_PRIORITY, NOT_ASKED, Setting, collector_off, real_time
from w2c_controller.calls import Calls
from w2c_controller.config import ControllerConfig
from w2c_controller.controller import Controller
from w2c_controller.loop.feed import StateFeed
from w2c_controller.loop.qp_meter import QpMeter
from w2c_controller.loop.rehearsal import rehearse
from w2c_controller.loop.reports import Reports
from w2c_controller.loop.timing import Timing
from w2c_controller.preview.search_process import SearchProcess
from w2c_controller.safety.outside import out_of_order, silence
from w2c_controller.seiko.contacts import Enabled
from w2c_controller.seiko.desired import STANDING
from w2c_controller.snapshots.handout import Handout
from w2c_controller.snapshots.keeper import Keeper

STATUS_EVERY = 25
"""Ticks between two status messages: 20 Hz."""
STATISTICS_EVERY = 250
"""Ticks between two reports of statistics: 2 Hz."""
SNAPSHOT_EVERY = 500
"""Ticks between two snapshots: 1 Hz."""
SNAPSHOT_PHASE = 137
"""Not a tick that reports something else."""
POLL_S = 0.1
RETRY_S = 0.2
SWITCH_INTERVAL_S = 0.0003
"""Calls share the interpreter with the loop, and must let go of it quickly."""

log = logging.getLogger("w2c.controller")


class ControllerNode:
    """See the module."""

    def __init__(self, config: ControllerConfig, bus: Bus, clock: Clock) -> None:
        self._config = config
        self._bus = bus
        self._clock = clock
        self._boot_id = ""
        self._answer: JointCommand | None = None
        self._trouble = ""
        self._retry_tick = -1
        self._skipped = 0
        self._stale = False
        self._feed: StateFeed | None = None
        self._granted = NOT_ASKED
        self._reports = Reports(bus)
        self._keeper = Keeper(bus, config.run_directory)
        self._snapshots: Handout[ControllerSnapshot] = Handout()
        self._last = self._keeper.last()
        self._kept: tuple[str, Enabled, tuple[str, ...]] = "", STANDING, ()
        self._begun = ""
        self.search = SearchProcess()
        self._calls = Calls(bus, self.search)
        self._switch_interval = sys.getswitchinterval()

    @property
    def detail(self) -> str:
        """What people should know of this process: what the system did not grant."""
        return self._granted.trouble

    @property
    def collections(self) -> int:
        """Runs of the garbage collector since the loop began."""
        return self._collector.runs

    def configure(self) -> None:
        """Ask the robot what it is, build the model, and take calls."""
        description = self._describe()
        rehearse(description)
        self._build(description)
        if self._description.lock_step:
            self._bus.use_lock_step()
            self._queue: Queue[RobotState] = self._bus.queue(topics.ROBOT_STATE)
        else:
            self._feed = StateFeed(
                self._bus.latest(topics.ROBOT_STATE),
                self._description.period_ns,
                old_ns=round(self._config.old_ms * 1e6),
            )
        self._calls.serve()
        self._bus.serve(topics.SNAPSHOT, lambda _request, _context: self._snapshots.ask(1.0))

    def run(self, stop: threading.Event) -> None:
        """Answer states until `stop`."""
        setting: Setting = "off" if self._feed is None else self._config.real_time
        sys.setswitchinterval(SWITCH_INTERVAL_S)
        # Before the threads are given precedence: one that holds the interpreter while others run
        # holds up the loop.
        self._reports.start()
        self._keeper.start()
        with (
            real_time(CONTROLLER_PRIORITY, setting) as self._granted,
            collector_off() as self._collector,
        ):
            if self._granted.trouble:
                log.warning("the loop may be late: %s", self._granted.trouble)
            while not stop.is_set():
                received = self._next_state()
                if received is None:
                    self._note_silence()
                else:
                    self._answer_state(received)

    def close(self) -> None:
        """Tell what waits, and give the interpreter back as it was."""
        self._reports.stop()
        self._keeper.stop()
        self.search.close()
        sys.setswitchinterval(self._switch_interval)

    # --- the loop --------------------------------------------------------------------------------
    def _next_state(self) -> Received[RobotState] | None:
        return self._queue.receive(POLL_S) if self._feed is None else self._feed.next()

    def _answer_state(self, received: Received[RobotState]) -> None:
        """Tick once, send the command, hand over what happened."""
        begin = time.monotonic_ns()
        state, source = received.message, received.as_input()
        if received.envelope.boot_id != self._boot_id:
            self._meet_robot(received.envelope.boot_id)
        if self._is_repeated(state):
            if self._answer is not None and state.tick == self._answer.tick:
                self._bus.publish(topics.JOINT_COMMAND, self._answer, (source,))
            return
        command = self._tick(state)
        if command is not None:
            self._answer = command
            self._bus.publish(topics.JOINT_COMMAND, command, (source,))
        for meter in self._meters:
            meter.step()
        late_ns = 0 if self._feed is None else self._feed.late_ns
        self._timing.add(late_ns, begin, time.monotonic_ns())
        self._report(state, received, command is None)

    def _is_repeated(self, state: RobotState) -> bool:
        """Tell whether a state is no news: answered already, or older than one that was."""
        self._end_silence()
        if self._answer is None:
            return False
        ahead = state.tick - self._answer.tick
        if ahead > 0:
            self._skipped += ahead - 1
            return False
        if ahead < 0:
            self._bus.count("state out of order")
            self.controller.found(out_of_order(state.tick, self._answer.tick))
        return True

    def _report(self, state: RobotState, received: Received[RobotState], failed: bool) -> None:
        """Hand over what happened in a tick."""
        controller, reports, stamp_ns = self.controller, self._reports, state.stamp_ns
        for event in controller.take_events():
            reports.goal(event, stamp_ns, received.as_input())
        for report in controller.take_safety_reports():
            reports.safety(report, stamp_ns, received.as_input())
        if state.tick % STATUS_EVERY == 0 or failed:
            reports.status(controller.snapshot(), self._timing, self._trouble, stamp_ns)
        if state.tick % STATISTICS_EVERY == 0:
            reports.statistics(
                stamp_ns, state.tick, self._timing, self._feed, self._skipped, self._meters,
                self.collections, self._granted,
            )  # fmt: skip
        if controller.takeover.how != self._begun:
            self._begun = controller.takeover.how
            reports.log(logging.WARNING, f"took over {self._begun}")
        self._keep_snapshot(state)

    def _keep_snapshot(self, state: RobotState) -> None:
        """Take a snapshot once a second, when something switched or holds, and when one asks."""
        controller = self.controller
        now = controller.phase, controller.retargeting.state.enabled, controller.waits
        switched = now != self._kept
        periodic = state.tick % SNAPSHOT_EVERY == SNAPSHOT_PHASE
        if not controller.takeover.done or not (switched or periodic or self._snapshots):
            return
        self._kept = now
        reason = "switch" if switched else "periodic" if periodic else "request"
        snapshot = ControllerSnapshot(
            stamp_ns=state.stamp_ns,
            tick=state.tick,
            reason=reason,
            robot_boot_id=self._boot_id,
            controller_boot_id=self._bus.boot_id,
            phase=controller.phase,
            in_contact=controller.retargeting.state.enabled,
            command=controller.command,
            state=controller.export(),
        )
        self._keeper.keep(snapshot)
        self._snapshots.serve(lambda: snapshot)

    def _note_silence(self) -> None:
        """Say once that states stopped coming; nothing is commanded meanwhile."""
        if self._feed is None or self._stale:
            return
        silence_ms = self._feed.silence_ns() * 1e-6
        if silence_ms < self._config.stale_ms:
            return
        self._stale = True
        self.controller.set_stale(True)
        hazard = silence(silence_ms, self._config.stale_ms)
        self.controller.found(hazard)
        self._trouble = hazard.text
        # Of no state: both carry the time of this clock, by which a recording tells them apart from
        # what was told of the last tick.
        stamp_ns = time.monotonic_ns()
        for report in self.controller.take_safety_reports():
            self._reports.safety(report, stamp_ns)
        self._reports.status(self.controller.snapshot(), self._timing, hazard.text, stamp_ns)

    def _end_silence(self) -> None:
        if self._stale:
            self._stale = False
            self.controller.set_stale(False)

    def _tick(self, state: RobotState) -> JointCommand | None:
        """Return the command of a state; None while the robot stands as it cannot be controlled."""
        if state.tick < self._retry_tick:
            return None
        try:
            command = self.controller.tick(state)
        except ControlError as error:
            self._trouble = str(error)
            self._retry_tick = state.tick + STATUS_EVERY
            log.error("cannot take over", extra={"reason": str(error)})
            return None
        self._trouble = ""
        return command

    def _meet_robot(self, boot_id: str) -> None:
        """Begin anew with a robot that restarted: its ticks do, and it may be another model."""
        if self._boot_id:
            log.warning("the robot restarted: taking over anew")
            self._build(self._describe())
        self._boot_id = boot_id
        if self._last is not None:
            self.controller.takeover.offer(self._last, boot_id)
            self._last = None

    def _build(self, description: RobotDescription) -> None:
        self._description = description
        self.controller = self._calls.controller = Controller(description)
        self.search.begin(description)
        self._timing = Timing(description.period_ns)
        self._meters = QpMeter(self.controller.solvers[0]), QpMeter(self.controller.solvers[1])
        self._answer = None

    def _describe(self) -> RobotDescription:
        """Ask the robot for its description until it answers. Raises ConnectionFailedError."""
        deadline = time.monotonic() + self._config.connect_timeout
        while True:
            try:
                return self._bus.call(topics.DESCRIBE, Empty()).message
            except CallError as error:
                if time.monotonic() > deadline:
                    raise ConnectionFailedError(
                        f"no robot '{self._bus.robot}' described itself within "
                        f"{self._config.connect_timeout:g} s at {self._config.robot_endpoint} "
                        f"({error}); start it with: w2c robot --robot {self._bus.robot}"
                    ) from error
            time.sleep(RETRY_S)
