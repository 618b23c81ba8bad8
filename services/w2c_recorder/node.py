"""The recorder on the bus: starts, stops and marks recordings, and reports once a second."""

import logging
import threading
import time
from pathlib import Path

from w2c import topics
from w2c.bus import Bus, CallContext, Envelope, Queue, RawReceived, encode_envelope
from w2c.bus.codec import ENVELOPE_VERSION
from w2c.clock import Clock
from w2c.errors import CallError, ConfigError, RecordingError, RefusedError
from w2c.messages import Empty, Health, MarkRequest, RecorderStatus, RecordRequest
from w2c_recorder.config import RecorderConfig
from w2c_recorder.foxglove.mirror import Mirror
from w2c_recorder.liveliness import Liveliness, LivelinessWatch, key_of
from w2c_recorder.mcap_file import McapFile
from w2c_recorder.metadata import Processes, session_metadata
from w2c_recorder.progress import Progress
from w2c_recorder.recovery import recover_directory
from w2c_recorder.writer_thread import Limits, WriterThread

STATUS_PERIOD_S = 1.0
DESCRIBE_TIMEOUT_S = 2.0
LOOKS_BEFORE_ASKING = 3
"""A process that has just appeared does not answer yet, and a call that fails would be told"""

log = logging.getLogger("w2c.recorder")


def next_path(directory: Path, stem: str = "session") -> Path:
    """Return the first free of session.mcap, session-1.mcap, session-2.mcap ... of a run."""
    path = directory / f"{stem}.mcap"
    number = 0
    while path.exists():
        number += 1
        path = directory / f"{stem}-{number}.mcap"
    return path


class RecorderNode:
    """Bus in, file out."""

    def __init__(self, config: RecorderConfig, bus: Bus, clock: Clock) -> None:
        del clock  # arrival is stamped by the bus
        self._config = config
        self._bus = bus
        self._watch = LivelinessWatch()
        self._liveliness_sequence: dict[str, int] = {}
        self._writer: WriterThread | None = None
        self._mirror = Mirror() if config.foxglove else None
        self._processes = Processes()
        self._health: Queue[Health] | None = None
        self._noted_path = ""
        self._described = False
        self._robot_seen = 0
        """Looks in a row at which the robot was there"""
        self._ask_at = LOOKS_BEFORE_ASKING

    def configure(self) -> None:
        """Recover what an earlier recorder left open, subscribe to everything, begin to record."""
        config = self._config
        if config.autostart and not config.run_directory:
            raise ConfigError("the recorder needs --run-directory DIR, or --no-autostart")
        if config.run_directory:
            self._prepare_directory(Path(config.run_directory))
        everything = f"w2c/{topics.VERSION}/{self._bus.robot}/**"
        self._writer = WriterThread(
            self._bus.raw_queue(everything, config.queue_size),
            self._new_file,
            successor=lambda first: next_path(first.parent, first.stem),
            limits=Limits(round(config.rotate_mb * 1e6), config.rotate_minutes * 60.0),
            minimum_free_bytes=int(config.minimum_free_mb * 1e6),
        )
        if config.autostart:
            try:
                self._writer.start(next_path(Path(config.run_directory)))
            except RecordingError as error:
                log.error("not recording: %s", error)
        self._health = self._bus.queue(topics.HEALTH)
        self._bus.serve(topics.RECORD_START, self._serve_start)
        self._bus.serve(topics.RECORD_STOP, self._serve_stop)
        self._bus.serve(topics.RECORD_STATUS, self._serve_status)
        self._bus.serve(topics.RECORD_MARK, self._serve_mark)

    def run(self, stop: threading.Event) -> None:
        """Publish the status and note who comes and goes, until stopped."""
        while not stop.is_set():
            self._begin_file()
            self._note_liveliness()
            self._note_processes()
            self._ask_robot()
            self._bus.publish(topics.RECORDER_STATUS, self._status())
            stop.wait(STATUS_PERIOD_S)

    def close(self) -> None:
        """Close the recording with index and summary."""
        if self._writer is not None:
            self._writer.shut_down()

    def _prepare_directory(self, directory: Path) -> None:
        try:
            directory.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            log.error("run directory %s cannot be made: %s", directory, error.strerror)
            return
        for recovered in recover_directory(directory):
            if recovered.problem:
                log.warning("recording left as it is: %s", recovered.problem)
            else:
                log.warning("recovered %d messages of %s", recovered.messages, recovered.path)

    def _new_file(self, path: Path) -> McapFile:
        metadata = session_metadata(self._bus.robot, self._config.run_directory, self._bus.boot_id)
        return McapFile(path, metadata, self._config.compression, self._mirror)

    def _serve_start(self, request: RecordRequest, _context: CallContext) -> RecorderStatus:
        return self._status(self._running().start(self._path_for(request.path)))

    def _serve_stop(self, _request: Empty, _context: CallContext) -> RecorderStatus:
        return self._status(self._running().stop())

    def _serve_status(self, _request: Empty, _context: CallContext) -> RecorderStatus:
        return self._status()

    def _serve_mark(self, request: MarkRequest, _context: CallContext) -> RecorderStatus:
        status = self._status()
        if not status.recording:
            raise RefusedError("nothing is being recorded; start with: w2c record start")
        self._bus.publish(topics.MARK, request)
        return status

    def _path_for(self, wanted: str) -> Path:
        """Return the file to write. Raises RefusedError for a path that is none for a recording."""
        directory = self._config.run_directory
        if not wanted:
            if not directory:
                raise RefusedError(
                    "the recorder has no run directory; name a file: --path FILE.mcap"
                )
            return next_path(Path(directory))
        path = Path(directory) / wanted
        if path.suffix != ".mcap":
            raise RefusedError(f"'{wanted}' does not end in .mcap")
        if path.exists():
            raise RefusedError(f"{path} exists; a recording is never written over")
        return path

    def _running(self) -> WriterThread:
        if self._writer is None:
            raise RefusedError("the recorder is still starting")
        return self._writer

    def _status(self, progress: Progress | None = None) -> RecorderStatus:
        progress = progress or self._running().progress
        return RecorderStatus(
            stamp_ns=time.time_ns(),
            recording=progress.recording,
            path=progress.path,
            messages=progress.messages,
            bytes=progress.bytes,
            lost=progress.lost,
            error=progress.error,
        )

    def _begin_file(self) -> None:
        """Let each new file, too, begin with who is there and what the robot is like."""
        path = self._running().progress.path
        if path != self._noted_path:
            self._noted_path = path
            self._watch = LivelinessWatch()
            self._processes.begin_file()
            self._described = False
            self._ask_at = LOOKS_BEFORE_ASKING
            self._robot_seen = 0

    def _ask_robot(self) -> None:
        """Ask for the robot's description, once a file: its trace puts it into the recording."""
        recording = self._running().progress.recording
        there = any(service == topics.DESCRIBE.service for service, _ in self._bus.alive())
        self._robot_seen = self._robot_seen + 1 if there else 0
        if self._described or not recording or self._robot_seen < self._ask_at:
            return
        try:
            self._bus.call(topics.DESCRIBE, Empty(), timeout_s=DESCRIBE_TIMEOUT_S)
            self._described = True
        except CallError as error:
            self._ask_at = 2 * self._robot_seen  # each attempt is in the recording
            log.debug("the robot is not described yet: %s", error)

    def _note_liveliness(self) -> None:
        """Write who came and went since the last look: the tokens themselves are no messages."""
        for change in self._watch.changes(self._bus.alive()):
            self._running().append(self._wrap(change))

    def _note_processes(self) -> None:
        """Write configurations and checksums of models, where they are not in this file yet."""
        while self._health is not None and (received := self._health.receive(0.0)) is not None:
            self._processes.note(received.message)
        if not self._running().progress.recording:
            return
        for name, facts in self._processes.news().items():
            self._running().describe(name, facts)

    def _wrap(self, change: Liveliness) -> RawReceived:
        key = key_of(self._bus.robot, change)
        sequence = self._liveliness_sequence.get(key, 0)
        self._liveliness_sequence[key] = sequence + 1
        now_ns = time.monotonic_ns()
        envelope = Envelope(
            version=ENVELOPE_VERSION,
            robot=self._bus.robot,
            sender=self._bus.service,
            boot_id=self._bus.boot_id,
            sequence=sequence,
            monotonic_ns=now_ns,
            clock_ns=time.time_ns(),
            inputs=[],
            data=change,
        )
        return RawReceived(key=key, payload=encode_envelope(envelope), received_ns=now_ns)
