"""The one thread that touches the file: drains the bus, writes, flushes, stops loudly."""

import logging
import queue
import shutil
import threading
import time
import uuid
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from w2c import topics
from w2c.bus import RawQueue, RawReceived
from w2c.errors import RecordingError, RefusedError
from w2c_recorder.mcap_file import McapFile
from w2c_recorder.progress import Progress, progress_of
from w2c_recorder.series import SERIES_METADATA, Part

FLUSH_PERIOD_S = 0.5
"""A killed recorder loses what came since the last flush."""
RECEIVE_TIMEOUT_S = 0.05
DRAIN_TIMEOUT_S = 2.0
"""How long a stop writes what is queued: a bus that never falls silent must not hold it up."""

SNAPSHOT_SUFFIX = f"/{topics.CONTROLLER_SNAPSHOT.key('*').split('/', 3)[-1]}"
SNAPSHOT_AGE_S = 5.0
"""An older one is of a controller that is gone; it would only make the file begin in the past"""

log = logging.getLogger("w2c.recorder")


@dataclass(frozen=True)
class Limits:
    """Beyond which the next file of a recording begins. 0 = never."""

    size_bytes: int = 0
    duration_s: float = 0.0


class WriterThread:
    """Writes all that a queue gives, while a recording is on. Any thread may call its methods.

    Commands run between two messages on the thread itself, so that a file needs no lock and no
    message is half inside a recording.
    """

    def __init__(
        self,
        messages: RawQueue,
        new_file: Callable[[Path], McapFile],
        *,
        successor: Callable[[Path], Path] | None = None,
        limits: Limits = Limits(),
        minimum_free_bytes: int = 0,
        free_bytes: Callable[[Path], int] = lambda directory: shutil.disk_usage(directory).free,
        wall_minus_monotonic_ns: Callable[[], int] = lambda: time.time_ns() - time.monotonic_ns(),
    ) -> None:
        """Start the thread.

        Args:
            messages: from the bus.
            new_file: makes a file.
            successor: path of the first file of a recording -> that of the next; None = a recording
                is one file.
            limits: of one file; beyond them the next one begins.
            minimum_free_bytes: the recording stops when less is free on its disk.
            free_bytes: of the disk of a directory.
            wall_minus_monotonic_ns: what turns arrivals into wall time.
        """
        self._messages = messages
        self._new_file = new_file
        self._successor = successor
        self._limits = limits
        self._first_path = Path()
        self._part = Part("", 0)
        self._began_at = 0.0
        self._snapshot: RawReceived | None = None
        self._minimum_free_bytes = minimum_free_bytes
        self._free_bytes = free_bytes
        self._wall_minus_monotonic_ns = wall_minus_monotonic_ns
        self._offset_ns = 0
        self._file: McapFile | None = None
        self._flush_at = 0.0
        self._progress = Progress()
        self._commands: queue.SimpleQueue[tuple[Callable[[], None], Future[Progress]]] = (
            queue.SimpleQueue()
        )
        self._ending = threading.Event()
        self._admission = threading.Lock()
        self._thread = threading.Thread(target=self._run, name="recorder-writer", daemon=True)
        self._thread.start()

    @property
    def progress(self) -> Progress:
        """State as of the last flush, at most half a second old."""
        return self._progress

    def start(self, path: Path) -> Progress:
        """Begin a file. Raises RecordingError: it cannot be made; RefusedError: one is open."""
        return self._execute(lambda: self._start(path))

    def stop(self) -> Progress:
        """Write what is queued, and close the file. Without a recording nothing happens."""
        return self._execute(self._finish)

    def append(self, received: RawReceived) -> None:
        """Write a message that did not come over the bus; ignored while no recording is on."""
        self._execute(lambda: self._write(received))

    def describe(self, name: str, values: dict[str, str]) -> None:
        """Write metadata; ignored while no recording is on."""
        self._execute(lambda: self._describe(name, values))

    def shut_down(self) -> None:
        """Close the recording, if any, and end the thread. Idempotent."""
        with self._admission:
            self._ending.set()
        self._thread.join()

    def _execute(self, command: Callable[[], None]) -> Progress:
        """Run a command on the thread and return the state after it; its error comes out here."""
        done: Future[Progress] = Future()
        with self._admission:  # what is admitted is run: its caller waits for it
            if self._ending.is_set():
                raise RefusedError("the recorder is shutting down")
            self._commands.put((command, done))
        return done.result()

    def _run(self) -> None:
        while not self._ending.is_set():
            self._run_commands()
            try:
                self._work()
            except Exception as error:  # the boundary: only the recording may end, and loudly
                log.exception("recorder failed")
                self._fail(RecordingError(f"the recorder failed: {error!r}"))
        self._run_commands()
        self._finish()

    def _work(self) -> None:
        """Take one message, if there is one."""
        received = self._messages.receive(RECEIVE_TIMEOUT_S)
        if received is not None:
            self._write(received)
        if self._file is not None and time.monotonic() >= self._flush_at:
            self._flush()

    def _run_commands(self) -> None:
        while not self._commands.empty():
            command, done = self._commands.get()
            try:
                command()
            except Exception as error:  # it belongs to the caller of the command
                done.set_exception(error)
            else:
                done.set_result(self._progress)

    def _start(self, path: Path) -> None:
        if self._file is not None:
            raise RefusedError(
                f"already recording into {self._file.path}; stop first: w2c record stop"
            )
        try:
            self._check_space(path)
            self._part = Part(uuid.uuid4().hex[:16], 0)
            self._file = self._make_file(path)
        except RecordingError as error:
            self._progress = Progress(path=str(path), error=str(error))
            raise
        self._first_path = path
        self._snapshot = None
        self._offset_ns = self._wall_minus_monotonic_ns()
        self._began_at = time.monotonic()
        log.info("recording", extra={"path": str(path)})
        self._flush()

    def _make_file(self, path: Path) -> McapFile:
        """Return a new file that says where it stands in its recording."""
        file = self._new_file(path)
        file.describe(SERIES_METADATA, self._part.metadata())
        return file

    def _write(self, received: RawReceived) -> None:
        if self._file is None:
            return
        with self._failing():
            self._file.write(received, received.received_ns + self._offset_ns)
        if received.key.endswith(SNAPSHOT_SUFFIX):
            self._snapshot = received

    def _describe(self, name: str, values: dict[str, str]) -> None:
        if self._file is None:
            return
        with self._failing():
            self._file.describe(name, values)

    @contextmanager
    def _failing(self) -> Iterator[None]:
        """End the recording, and nothing else, at whatever goes wrong: its sender can't help it."""
        try:
            yield
        except RecordingError as error:
            self._fail(error)
        except Exception as error:  # the boundary, as that of the thread
            log.exception("recorder failed")
            self._fail(RecordingError(f"the recorder failed: {error!r}"))

    def _flush(self) -> None:
        """Make what was written survive a crash, and see whether there is room for more."""
        if self._file is None:
            return
        self._flush_at = time.monotonic() + FLUSH_PERIOD_S
        try:
            self._file.flush()
            self._note(self._file)
        except RecordingError as error:
            self._fail(error)
            return
        try:
            self._check_space(self._file.path)
        except RecordingError as error:
            self._finish(str(error))  # only the reserve is touched: there is room for the end
            return
        self._rotate(self._file)

    def _rotate(self, file: McapFile) -> None:
        """Begin the next file where this one is full. Nothing is lost: the bus waits in its queue.

        It begins with the controller's last snapshot, so that each file can be replayed alone.
        """
        size, duration = self._limits.size_bytes, self._limits.duration_s
        full = 0 < size <= file.bytes_written
        old = 0.0 < duration <= time.monotonic() - self._began_at
        if self._successor is None or not (full or old) or not file.messages:
            return
        try:
            file.close()
        except RecordingError as error:
            self._fail(error)
            return
        path = self._successor(self._first_path)
        self._part = Part(self._part.series, self._part.number + 1)
        try:
            self._file = self._make_file(path)
        except RecordingError as error:
            self._file = None
            self._progress = progress_of(file, recording=False, error=str(error))
            log.error("recording stopped: %s", error)
            return
        self._file.losses = file.losses  # what is missing between two files is missing, too
        self._began_at = time.monotonic()
        log.info("recording goes on in the next file", extra={"path": str(path)})
        if self._snapshot is not None and self._is_recent(self._snapshot):
            self._write(self._snapshot)
        if self._file is not None:
            self._note(self._file)

    @staticmethod
    def _is_recent(received: RawReceived) -> bool:
        return time.monotonic_ns() - received.received_ns < SNAPSHOT_AGE_S * 1e9

    def _finish(self, error: str = "") -> None:
        """Write what is queued, and close."""
        self._drain()
        file = self._file
        if file is None:  # none was on, or the drain filled the disk
            return
        try:
            file.close()
        except RecordingError as problem:
            self._fail(problem)
            return
        self._file = None
        self._progress = progress_of(file, recording=False, error=error)
        if error:
            log.error("recording stopped: %s", error)
        else:
            log.info("recording closed", extra={"path": str(file.path)})

    def _drain(self) -> None:
        """Write what came before now, as far as that takes no longer than a stop may."""
        asked_ns = time.monotonic_ns()
        deadline = time.monotonic() + DRAIN_TIMEOUT_S
        while self._file is not None:
            received = self._messages.receive(0.0)
            if received is None or received.received_ns > asked_ns:
                return
            if time.monotonic() >= deadline:
                log.error(
                    "the last %.1f s are not in the recording: the disk or the processor is too "
                    "slow for what was to be written",
                    (asked_ns - received.received_ns) * 1e-9,
                )
                return
            self._write(received)

    def _fail(self, error: RecordingError) -> None:
        """Stop the recording and nothing else, and say so."""
        file, self._file = self._file, None
        if file is not None:
            file.abandon()
            self._progress = progress_of(file, recording=False, error=str(error))
            log.error("recording stopped: %s", error)

    def _check_space(self, path: Path) -> None:
        """Raise RecordingError before the disk is so full that other processes suffer."""
        try:
            free = self._free_bytes(path.parent)
        except OSError as error:
            raise RecordingError(f"{path.parent} cannot be written: {error.strerror}") from error
        if free < self._minimum_free_bytes:
            raise RecordingError(
                f"{path.parent} has {free / 1e6:.0f} MB left, the recorder leaves "
                f"{self._minimum_free_bytes / 1e6:.0f} MB to others. "
                "Make room, then: w2c record start"
            )

    def _note(self, file: McapFile) -> None:
        if file.malformed > self._progress.malformed:
            log.warning("%d messages recorded that have no readable envelope", file.malformed)
        self._progress = progress_of(file, recording=True)
