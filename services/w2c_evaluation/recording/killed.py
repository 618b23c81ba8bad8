"""A whole session killed while it runs, and how much of its recording can be read."""

import itertools
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
BEFORE_S = 5.0
"""Before the last message that can be read: how often messages came then"""


@dataclass(frozen=True)
class Killed:
    """What a killed session left."""

    messages: int
    """That can be read"""
    lost_s: float
    """From the arrival of the last of them to the kill [s]; at most so much is lost. Where nothing
    was written yet: from the first bytes of the file."""
    silence_s: float
    """Longest time without any message shortly before that [s]: where little is sent, such as while
    everything starts, so long a time may pass without a loss"""

    @property
    def surely_lost_s(self) -> float:
        """Return the part of `lost_s` in which a message must have come [s]."""
        return max(0.0, self.lost_s - self.silence_s)


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
        ProcessError: the session ended by itself, or began no recording.
        RecordingError: the file cannot be read.
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
        began_ns = time.time_ns()
        time.sleep(after_s)
        _check_that_it_runs(session, directory)
    finally:
        killed_ns = time.time_ns()
        _kill_all(session)
    arrivals = [one.log_time_ns for one in library("recording")(path).messages(decode=False)]
    arrivals = sorted([began_ns, *arrivals])
    # Processes die one after the other: a message may come after the first of them was killed.
    lost_ns = max(0, killed_ns - arrivals[-1])
    return Killed(len(arrivals) - 1, lost_ns * 1e-9, longest_silence_s(arrivals))


def longest_silence_s(arrivals_ns: Sequence[int], before_s: float = BEFORE_S) -> float:
    """Return the longest time between two arrivals, sorted [ns], of the last `before_s` [s]."""
    recent = [one for one in arrivals_ns if one > arrivals_ns[-1] - before_s * 1e9]
    return max((b - a for a, b in itertools.pairwise(recent)), default=0) * 1e-9


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
