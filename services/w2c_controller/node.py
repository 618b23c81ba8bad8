"""The controller on the bus: states in, commands out, goals from threads of their own.

Real time: the newest state is answered; ticks that were missed are skipped, and the motion is
slower by
them. Lock step: every state is answered once, and one that comes again gets the same answer again.
"""

import gc
import logging
import sys
import threading
import time

import numpy as np

from w2c import topics
from w2c.bus import Bus, Input, Latest, Queue, Received
from w2c.bus.interface import CallContext
from w2c.clock import Clock
from w2c.errors import CallError, ConnectionFailedError, ControlError
from w2c.messages import (
    ControllerStatus,
    Empty,
    GoalEvent,
    GoalReply,
    JointCommand,
    PlaceGoal,
    PreviewReply,
    ReleaseGoal,
    RobotDescription,
    RobotState,
    StopReply,
    StopRequest,
)
from w2c_controller.config import ControllerConfig
from w2c_controller.controller import Controller
from w2c_controller.events import Event
from w2c_controller.parameters import EFFECTORS
from w2c_controller.preview import preview
from w2c_controller.search import StaticSearch
from w2c_controller.timing import Timing

STATUS_EVERY = 25
"""Ticks between two status messages: 20 Hz."""
POLL_S = 0.1
RETRY_S = 0.2
SWITCH_INTERVAL_S = 0.0003
"""A preview shares the interpreter with the loop, and must let go of it quickly."""

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
        self._switch_interval = sys.getswitchinterval()

    def configure(self) -> None:
        """Ask the robot what it is, build the model, and take calls."""
        self._build(self._describe())
        if self._description.lock_step:
            self._bus.use_lock_step()
            self._queue: Queue[RobotState] = self._bus.queue(topics.ROBOT_STATE)
        else:
            self._latest: Latest[RobotState] = self._bus.latest(topics.ROBOT_STATE)
        self._bus.serve(topics.PLACE, self._place)
        self._bus.serve(topics.RELEASE, self._release)
        self._bus.serve(topics.CONTROLLER_STOP, self._stop)
        self._bus.serve(topics.PREVIEW, self._preview)

    def run(self, stop: threading.Event) -> None:
        """Answer states until `stop`."""
        # What was built lives as long as the process: the collector need not look at it again.
        gc.collect()
        gc.freeze()
        sys.setswitchinterval(SWITCH_INTERVAL_S)
        stale = False
        while not stop.is_set():
            received = self._next_state()
            if received is not None:
                stale = False
                self.controller.set_stale(False)
                self._answer_state(received)
            elif not self._description.lock_step and not stale:
                stale = True
                self.controller.set_stale(True)
                self._trouble = (
                    f"no state of the robot for {self._config.stale_ms:g} ms: not commanding"
                )
                log.warning("state is stale", extra={"limit_ms": self._config.stale_ms})
                self._publish_status(time.monotonic_ns())

    def close(self) -> None:
        """Give the interpreter back as it was."""
        sys.setswitchinterval(self._switch_interval)
        gc.unfreeze()

    # --- the loop --------------------------------------------------------------------------------
    def _next_state(self) -> Received[RobotState] | None:
        if self._description.lock_step:
            return self._queue.receive(POLL_S)
        return self._latest.wait(self._config.stale_ms * 1e-3)

    def _answer_state(self, received: Received[RobotState]) -> None:
        """Tick once, publish the command and what happened."""
        begin = time.monotonic_ns()
        state = received.message
        if received.envelope.boot_id != self._boot_id:
            self._meet_robot(received.envelope.boot_id)
        if self._answer is not None and state.tick == self._answer.tick:
            self._bus.publish(topics.JOINT_COMMAND, self._answer, (received.as_input(),))
            return
        command = self._tick(state)
        if command is not None:
            self._answer = command
            self._bus.publish(topics.JOINT_COMMAND, command, (received.as_input(),))
        self._timing.add(received.received_ns, begin, time.monotonic_ns())
        for event in self.controller.take_events():
            self._publish_event(event, state.stamp_ns, received.as_input())
        if state.tick % STATUS_EVERY == 0 or command is None:
            self._publish_status(state.stamp_ns)

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

    def _build(self, description: RobotDescription) -> None:
        self._description = description
        self.controller = Controller(description)
        self._search = StaticSearch(self.controller.model)
        self._timing = Timing(description.period_ns)
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

    # --- what is published -----------------------------------------------------------------------
    def _publish_event(self, event: Event, stamp_ns: int, source: Input) -> None:
        message = GoalEvent(
            stamp_ns=stamp_ns,
            goal_id=event.goal_id,
            end_effector=EFFECTORS[event.effector],
            task=event.task,
            state=event.state,
            reason=event.reason,
            distance=event.distance,
        )
        self._bus.publish(topics.GOAL_EVENT, message, (source,))
        log.info("goal %s %s", event.goal_id, event.state, extra={"reason": event.reason})

    def _publish_status(self, stamp_ns: int) -> None:
        snapshot = self.controller.snapshot()
        status = ControllerStatus(
            stamp_ns=stamp_ns,
            tick=snapshot.tick,
            phase=snapshot.phase,
            goal_id=snapshot.goal_id,
            end_effector=snapshot.end_effector,
            task=snapshot.task,
            distance=snapshot.distance,
            in_contact=snapshot.in_contact,
            desired_forces=snapshot.desired_forces,
            end_effector_positions=snapshot.positions,
            loads=np.nan_to_num(snapshot.loads, nan=-1.0),
            solver_failures=snapshot.solver_failures,
            lateness_us=self._timing.lateness_us(),
            tick_us=self._timing.tick_us(),
            message=self._trouble or snapshot.message,
        )
        self._bus.publish(topics.CONTROLLER_STATUS, status)

    # --- calls, each on a thread of its own ------------------------------------------------------
    def _place(self, request: PlaceGoal, _: CallContext) -> GoalReply:
        return self.controller.requests.place(request)

    def _release(self, request: ReleaseGoal, _: CallContext) -> GoalReply:
        return self.controller.requests.release(request)

    def _stop(self, request: StopRequest, context: CallContext) -> StopReply:
        """Hold at once, and have the driver hold, which outlives this process."""
        self.controller.freeze(request.reason)
        log.warning("stop from %s: %s", context.caller, request.reason or "no reason given")
        return self._bus.call(topics.ROBOT_STOP, request).message

    def _preview(self, request: PlaceGoal, _: CallContext) -> PreviewReply:
        """Search on a copy of the desired state; the loop goes on meanwhile."""
        return preview(self._search, self.controller.desired_copy(timeout_s=1.0), request)
