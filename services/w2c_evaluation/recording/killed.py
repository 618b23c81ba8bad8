"""A whole session killed while it runs, and how much of its recording can be read."""

import subprocess
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import psutil

from w2c.errors import ProcessError
from w2c.library import library

RECORDING = "session.mcap"
START_PATIENCE_S = 600.0
"""Until something is recorded: models are loaded before, on a slow machine too"""
KILL_PATIENCE_S = 10.0


@dataclass(frozen=True)
class Killed:
    """What a killed session left."""

    messages: int
    """That can be read"""
    lost_s: float
    """From the arrival of the last of them to the kill [s]; at most so much is lost"""


def kill_session(
    command: Sequence[str], directory: Path, after_s: float, patience_s: float = START_PATIENCE_S
) -> Killed:
    """Start a session, kill every process of it, and read what it recorded.

    Args:
        command: starts the session and stays while it runs.
        directory: where the session records.
        after_s: from the first recorded bytes to the kill [s].
        patience_s: until the first recorded bytes [s].

    Raises:
        ProcessError: the session ended by itself, or recorded nothing.
        RecordingError: nothing can be read.
    """
    path = directory / RECORDING
    session = psutil.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    try:
        deadline = time.monotonic() + patience_s
        while not (path.exists() and path.stat().st_size):
            if session.poll() is None and time.monotonic() > deadline:
                raise ProcessError(f"nothing was recorded in {directory} within {patience_s:g} s")
            _check_that_it_runs(session, directory)
            time.sleep(0.05)
        time.sleep(after_s)
        _check_that_it_runs(session, directory)
    finally:
        killed_ns = time.time_ns()
        _kill_all(session)
    arrivals = [one.log_time_ns for one in library("recording")(path).messages(decode=False)]
    if not arrivals:
        raise ProcessError(f"{path} holds no message {after_s:.1f} s after recording began")
    return Killed(len(arrivals), (killed_ns - max(arrivals)) * 1e-9)


def _check_that_it_runs(session: psutil.Popen, directory: Path) -> None:
    if session.poll() is not None:
        raise ProcessError(
            f"the session in {directory} ended by itself, with status {session.returncode}, "
            "before it was killed; look at the logs there, or run it alone"
        )


def _kill_all(session: psutil.Popen) -> None:
    """Kill a process and all below it, children first: a dead parent lets them end in order."""
    family = [*reversed(session.children(recursive=True)), session] if session.is_running() else []
    for process in family:
        with suppress(psutil.NoSuchProcess):
            process.kill()
    deadline = time.monotonic() + KILL_PATIENCE_S
    while any(_is_alive(process) for process in family) and time.monotonic() < deadline:
        time.sleep(0.01)
    session.wait()


def _is_alive(process: psutil.Process) -> bool:
    try:
        return bool(process.status() != psutil.STATUS_ZOMBIE)  # which nobody has waited for yet
    except psutil.NoSuchProcess:
        return False
