"""Snapshots on their way out of the loop: published, and kept in a file for the next process."""

import threading
from pathlib import Path
from queue import SimpleQueue

from w2c import topics
from w2c.bus import Bus
from w2c.bus.codec import decode_message, encode_message
from w2c.errors import MessageError
from w2c.messages import ControllerSnapshot

FILE = "controller_snapshot.msgpack"
MOST_BYTES = 1_000_000


class Keeper:
    """Publishes and writes snapshots on a thread of its own."""

    def __init__(self, bus: Bus, run_directory: str) -> None:
        """Begin without a snapshot; an empty run directory keeps none on disk."""
        self._bus = bus
        self._path = Path(run_directory) / FILE if run_directory else None
        self._queue: SimpleQueue[ControllerSnapshot | None] = SimpleQueue()
        self._thread = threading.Thread(target=self._run, name="snapshots", daemon=True)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def stop(self) -> None:
        """Keep what waits, and end the thread."""
        if self._thread.is_alive():
            self._queue.put(None)
            self._thread.join(timeout=5.0)

    def keep(self, snapshot: ControllerSnapshot) -> None:
        """Take a snapshot from the loop. Never blocks."""
        self._queue.put(snapshot)

    def last(self) -> ControllerSnapshot | None:
        """Return the snapshot of the process before this one; None without a readable file."""
        if self._path is None or not self._path.is_file():
            return None
        try:
            return decode_message(self._path.read_bytes(), ControllerSnapshot, MOST_BYTES)
        except (OSError, MessageError):
            self._bus.count("snapshot not readable")
            return None

    def _run(self) -> None:
        while True:
            snapshot = self._queue.get()
            if snapshot is None:
                return
            self._bus.publish(topics.CONTROLLER_SNAPSHOT, snapshot)
            if self._path is not None:
                self._write(self._path, encode_message(snapshot))

    def _write(self, path: Path, payload: bytes) -> None:
        """Replace the file at once: whoever reads it finds the old snapshot or the new one."""
        new = path.with_suffix(".new")
        try:
            new.write_bytes(payload)
            new.replace(path)
        except OSError:
            self._bus.count("snapshot not written")
