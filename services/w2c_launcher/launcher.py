"""Starts the processes of a profile in stages, restarts what dies, stops in order."""

import logging
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from w2c import topics
from w2c.bus import Bus, Queue
from w2c.errors import ProcessError
from w2c.messages import Health, ProcessState, ProcessTable
from w2c_launcher.child import Child
from w2c_launcher.profiles import ProcessSpec
from w2c_launcher.restart_policy import RestartPolicy

READY_PATIENCE_S = 180.0
SILENCE_S = 8.0
"""Without a health report for this long a process is shown as silent"""

log = logging.getLogger("w2c.launcher")
Progress = Callable[[str, str], None]


@dataclass
class Slot:
    """What the launcher knows of one process."""

    spec: ProcessSpec
    child: Child | None = None
    phase: str = "stopped"
    detail: str = ""
    policy: RestartPolicy = field(default_factory=RestartPolicy)
    restart_at: float = 0.0
    last_health: float = 0.0


class Launcher:
    """Looks after the processes of one profile. Not thread-safe: one thread owns it."""

    def __init__(self, specs: list[ProcessSpec], run_directory: Path, progress: Progress) -> None:
        self._slots = {spec.name: Slot(spec) for spec in specs}
        self._run_directory = run_directory
        self._progress = progress
        self._bus: Bus | None = None
        self._reports: Queue[Health] | None = None

    def start_stage(self, stage: int) -> None:
        """Start every process of a stage."""
        for slot in self._slots.values():
            if slot.spec.stage == stage:
                self._start(slot)

    def attach(self, bus: Bus) -> None:
        """Listen to health reports from now on, and publish the table of processes."""
        self._bus = bus
        self._reports = bus.queue(topics.HEALTH)

    def wait_ready(self, stage: int, should_stop: Callable[[], bool]) -> None:
        """Return when every process of the stage is ready.

        Raises:
            ProcessError: one of them gave up, or is not ready within READY_PATIENCE_S.
        """
        deadline = time.monotonic() + READY_PATIENCE_S
        waiting = [s for s in self._slots.values() if s.spec.stage == stage]
        while not should_stop():
            self.watch()
            late = [slot for slot in waiting if slot.phase != "ready"]
            if not late:
                return
            for slot in late:
                if slot.phase == "failed":
                    raise ProcessError(f"{slot.spec.name} does not start: {slot.detail}")
            if time.monotonic() > deadline:
                names = ", ".join(f"{s.spec.name} ({s.phase}: {s.detail})" for s in late)
                raise ProcessError(
                    f"not ready after {READY_PATIENCE_S:.0f} s: {names}. "
                    f"Their logs are in {self._run_directory}"
                )

    def watch(self) -> None:
        """Do one round: read health, notice deaths, restart what is due. Takes about 0.1 s."""
        self._read_health(0.1)
        now = time.monotonic()
        for slot in self._slots.values():
            if slot.child is not None and slot.child.exit_status is not None:
                self._bury(slot, now)
            elif slot.phase == "restarting" and now >= slot.restart_at:
                self._start(slot)
            elif slot.phase == "starting" and not slot.spec.joins_bus:
                self._set(slot, "ready")
            elif slot.phase == "ready" and slot.spec.joins_bus:
                silent = now - slot.last_health
                slot.detail = f"silent for {silent:.0f} s" if silent > SILENCE_S else ""

    def publish(self) -> None:
        """Publish the table of processes."""
        if self._bus is not None:
            self._bus.publish(topics.PROCESS_TABLE, self.table())

    def table(self) -> ProcessTable:
        """Return the state of every process."""
        states = [
            ProcessState(
                name=slot.spec.name,
                phase=slot.phase,
                pid=None if slot.child is None else slot.child.pid,
                restarts=slot.policy.restarts,
                detail=slot.detail[:2000],
            )
            for slot in self._slots.values()
        ]
        return ProcessTable(
            stamp_ns=time.time_ns(), run_directory=str(self._run_directory), processes=states
        )

    @property
    def all_ready(self) -> bool:
        """Tell whether every process is ready."""
        return all(slot.phase == "ready" for slot in self._slots.values())

    def stop(self) -> None:
        """Stop every process, in order: what depends on others first, recorder and router last."""
        for stage in sorted({slot.spec.stop_stage for slot in self._slots.values()}):
            slots = [s for s in self._slots.values() if s.spec.stop_stage == stage and s.child]
            for slot in slots:
                if slot.child is not None:
                    slot.child.terminate()
            for slot in slots:
                if slot.child is not None and not slot.child.wait_or_kill():
                    log.warning("%s did not stop by itself and was killed", slot.spec.name)
                slot.child = None
                self._set(slot, "stopped")

    def _start(self, slot: Slot) -> None:
        slot.child = Child(slot.spec.name, slot.spec.flags, self._run_directory, slot.spec.niceness)
        slot.last_health = time.monotonic()
        self._set(slot, "starting")

    def _bury(self, slot: Slot, now: float) -> None:
        """Decide what becomes of a process that ended without being asked."""
        if slot.child is None:
            return
        status, words = slot.child.exit_status, slot.child.last_words()
        slot.child = None
        detail = f"exit status {status}: {words}"
        # Status 2 is wrong usage: the same flags would fail again.
        delay = None if status == 2 else slot.policy.died(now)
        if delay is None:
            self._set(slot, "failed", detail)
            return
        slot.restart_at = now + delay
        self._set(slot, "restarting", f"{detail}; again in {delay:.1f} s")

    def _read_health(self, patience_s: float) -> None:
        if self._reports is None:
            time.sleep(patience_s)
            return
        received = self._reports.receive(patience_s)
        while received is not None:
            health = received.message
            slot = self._slots.get(health.service)
            # A report of a process that died meanwhile must not count for its successor.
            if slot is not None and slot.child is not None and slot.child.pid == health.pid:
                slot.last_health = time.monotonic()
                if health.phase == "ready" and slot.phase != "ready":
                    self._set(slot, "ready")
                elif health.phase == "configure":
                    slot.detail = health.detail
            received = self._reports.receive(0.0)

    def _set(self, slot: Slot, phase: str, detail: str = "") -> None:
        slot.phase, slot.detail = phase, detail
        self._progress(slot.spec.name, f"{phase} {detail}".strip())
        self.publish()
