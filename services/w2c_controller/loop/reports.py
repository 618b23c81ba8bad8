"""What is told of the loop, published by a thread of its own: the loop hands over, and goes on."""

import logging
import sys
import threading
from collections.abc import Callable
from functools import partial
from queue import SimpleQueue

import numpy as np
import numpy.typing as npt

from w2c import topics
from w2c.bus import Bus, Input
from w2c.geometry import quaternion_from_rotation
from w2c.messages import ControllerStatistics, ControllerStatus, GoalEvent, SafetyEvent
from w2c.realtime import RealTime
from w2c_controller.loop.feed import StateFeed
from w2c_controller.loop.qp_meter import QpMeter
from w2c_controller.loop.summary import Snapshot
from w2c_controller.loop.timing import BIN_EDGES_US, Timing
from w2c_controller.parameters import EFFECTORS
from w2c_controller.safety.hazards import SafetyReport
from w2c_controller.switching.events import Event

MOST_WAITING = 1000
"""More reports than this wait for nobody: the next ones are dropped, and counted."""

log = logging.getLogger("w2c.controller")


class Reports:
    """A queue of things to tell, and the thread that tells them."""

    def __init__(self, bus: Bus) -> None:
        self._bus = bus
        self._queue: SimpleQueue[Callable[[], None] | None] = SimpleQueue()
        self._thread = threading.Thread(target=self._run, name="reports", daemon=True)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def stop(self) -> None:
        """Tell what waits, and end the thread."""
        if self._thread.is_alive():
            self._queue.put(None)
            self._thread.join(timeout=5.0)

    def post(self, work: Callable[[], None]) -> None:
        """Have something done by the thread. Never blocks."""
        if self._queue.qsize() < MOST_WAITING:
            self._queue.put(work)
        else:
            self._bus.count("reports dropped")

    # --- from the loop ---------------------------------------------------------------------------
    def log(self, level: int, text: str, **fields: object) -> None:
        """Write into the log."""
        self.post(partial(log.log, level, text, extra=fields))

    def goal(self, event: Event, stamp_ns: int, source: Input) -> None:
        """Tell that a goal changed its state."""
        self.post(partial(self._publish_goal, event, stamp_ns, source))

    def safety(self, report: SafetyReport, stamp_ns: int, source: Input | None = None) -> None:
        """Tell that a hazard began or ended."""
        self.post(partial(self._publish_safety, report, stamp_ns, source))

    def status(self, snapshot: Snapshot, timing: Timing, trouble: str, stamp_ns: int) -> None:
        """Tell what the controller does."""
        self.post(partial(self._publish_status, snapshot, timing, trouble, stamp_ns))

    def statistics(
        self,
        stamp_ns: int,
        tick: int,
        timing: Timing,
        feed: StateFeed | None,
        skipped: int,
        meters: tuple[QpMeter, QpMeter],
        collections: int,
        real_time: RealTime,
    ) -> None:
        """Tell how the loop keeps time and how its programs fare."""
        self.post(
            partial(
                self._publish_statistics,
                stamp_ns, tick, timing, feed, skipped, meters, collections, real_time,
            )
        )  # fmt: skip

    # --- on the thread ---------------------------------------------------------------------------
    def _run(self) -> None:
        while True:
            work = self._queue.get()
            if work is None:
                return
            try:
                work()
            except Exception:  # the boundary: one report that fails must not end all others
                self._bus.count("reports failed")
                log.exception("a report of the loop failed")

    def _publish_goal(self, event: Event, stamp_ns: int, source: Input) -> None:
        self._bus.publish(topics.GOAL_EVENT, goal_message(event, stamp_ns), (source,))
        log.info("goal %s %s", event.goal_id, event.state, extra={"reason": event.reason})

    def _publish_safety(self, report: SafetyReport, stamp_ns: int, source: Input | None) -> None:
        hazard, message = report.hazard, safety_message(report, stamp_ns)
        self._bus.publish(topics.SAFETY_EVENT, message, () if source is None else (source,))
        if report.begins:
            log.warning(
                "the robot %s: %s", message.answer, message.text, extra={"cause": hazard.cause}
            )
        else:
            log.info("over: %s", hazard.text, extra={"cause": hazard.cause})

    def _publish_status(
        self, snapshot: Snapshot, timing: Timing, trouble: str, stamp_ns: int
    ) -> None:
        times = timing.lateness_us(), timing.tick_us()
        message = status_message(snapshot, *times, trouble, stamp_ns)
        self._bus.publish(topics.CONTROLLER_STATUS, message)

    def _publish_statistics(
        self,
        stamp_ns: int,
        tick: int,
        timing: Timing,
        feed: StateFeed | None,
        skipped: int,
        meters: tuple[QpMeter, QpMeter],
        collections: int,
        real_time: RealTime,
    ) -> None:
        message = ControllerStatistics(
            stamp_ns=stamp_ns,
            tick=tick,
            ticks=timing.ticks,
            missed_deadlines=0 if feed is None else feed.missed,
            skipped_ticks=skipped,
            old_states=0 if feed is None else feed.old,
            gaps_20ms=timing.gaps,
            bin_edges_us=np.array(BIN_EDGES_US),
            lateness_counts=timing.lateness_counts.copy(),
            duration_counts=timing.duration_counts.copy(),
            lateness_max_us=timing.lateness_max_us,
            duration_max_us=timing.duration_max_us,
            retargeting=meters[0].report(),
            force_control=meters[1].report(),
            collections=collections,
            allocated_blocks=sys.getallocatedblocks(),
            memory_locked=real_time.memory_locked,
            real_time_priority=real_time.priority,
            real_time=real_time.trouble,
        )
        self._bus.publish(topics.CONTROLLER_STATISTICS, message)


def goal_message(event: Event, stamp_ns: int) -> GoalEvent:
    """Return what is told of a goal, of the robot's time [ns]."""
    return GoalEvent(
        stamp_ns=stamp_ns,
        goal_id=event.goal_id,
        end_effector=EFFECTORS[event.effector],
        task=event.task,
        state=event.state,
        reason=event.reason,
        distance=event.distance,
    )


def safety_message(report: SafetyReport, stamp_ns: int) -> SafetyEvent:
    """Return what is told of a hazard, of the robot's time [ns]."""
    hazard, rule = report.hazard, report.rule
    return SafetyEvent(
        stamp_ns=stamp_ns,
        tick=report.tick,
        cause=hazard.cause,
        state="begins" if report.begins else "ends",
        subject=hazard.subject,
        value=hazard.value,
        limit=hazard.limit,
        unit=hazard.unit,
        answer=rule.answer,
        resumes=rule.resumes,
        text=f"{hazard.text}: {rule.advice}",
    )


def status_message(
    snapshot: Snapshot,
    lateness_us: dict[str, float],
    tick_us: dict[str, float],
    trouble: str,
    stamp_ns: int,
) -> ControllerStatus:
    """Return what is told of the controller, of the robot's time [ns]."""
    return ControllerStatus(
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
        lateness_us=lateness_us,
        tick_us=tick_us,
        message=trouble or snapshot.message,
        soles=_soles(snapshot),
    )


def _soles(snapshot: Snapshot) -> npt.NDArray[np.float64] | None:
    """Return where the feet are (2, 7): position, quaternion xyzw; None where it is not known."""
    rotations = snapshot.sole_rotations
    if rotations is None:
        return None
    quaternions = [quaternion_from_rotation(rotation) for rotation in rotations]
    return np.hstack([snapshot.positions[:2], np.stack(quaternions)])
