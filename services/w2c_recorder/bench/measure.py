"""What recording and replay cost, as `w2c bench recording` reports it."""

import json
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from w2c.bus import InProcessHub
from w2c.clock import RealClock
from w2c.errors import ProcessError
from w2c_recorder.bench.load import SENT_SUFFIX
from w2c_recorder.reading import Recording
from w2c_recorder.replay.options import ReplayOptions
from w2c_recorder.replay.run import play, quick_switches

SEEKS = 20
KILLED_RATE = 15e6
START_PATIENCE_S = 60.0


@dataclass(frozen=True)
class Figure:
    """One measured quantity of one case."""

    case: str
    metric: str
    values: list[float]
    unit: str


def measure(
    directory: Path, rates_mb_s: tuple[float, ...], seconds: float, kills: int, seed: int
) -> Iterator[Figure]:
    """Record at each rate, seek in and replay what was recorded, and kill recorders.

    Args:
        directory: for the recordings; they stay.
        rates_mb_s: of the messages [MB/s].
        seconds: of each recording [s].
        kills: recorders to kill.
        seed: of the instants.

    Raises:
        ProcessError: a recorder under load ended by itself.
    """
    rng = np.random.default_rng(seed)
    for rate in rates_mb_s:
        case, path = f"{rate:g} MB/s", directory / f"rate-{rate:g}.mcap"
        yield from _recorded(case, path, rate * 1e6, seconds)
        yield Figure(case, "seek_ms", [_seek_ms(path, rng) for _ in range(SEEKS)], "ms")
        yield from _replayed(case, path)
    yield from _killed(directory, seconds, kills, rng)


def _recorded(case: str, path: Path, bytes_per_s: float, seconds: float) -> Iterator[Figure]:
    answer = subprocess.run(
        _command(path, bytes_per_s, seconds), capture_output=True, text=True, check=False
    )
    if answer.returncode != 0:
        raise ProcessError(f"the recorder under load ended: {answer.stderr.strip()[-500:]}")
    found = json.loads(answer.stdout)
    elapsed = found["sending_s"] + found["backlog_s"]
    yield Figure(case, "recorded", [found["sent_bytes"] / elapsed * 1e-6], "MB/s")
    yield Figure(case, "backlog", [found["backlog_s"]], "s")
    yield Figure(case, "writer_cpu", [100.0 * found["cpu_s"] / found["sending_s"]], "% of a core")
    yield Figure(case, "longest_write", [found["longest_s"] * 1e3], "ms")
    yield Figure(case, "lost", [found["lost"]], "messages")
    yield Figure(case, "file_size", [found["file_bytes"] / found["sent_bytes"]], "of the messages")


def _seek_ms(path: Path, rng: np.random.Generator, span_s: float = 1.0) -> float:
    """Return the time from nothing known to the first message of a random instant [ms]."""
    recording = Recording(path)
    recording.read_metadata()
    span_ns = round(span_s * 1e9)
    at_ns = recording.start_ns + int(rng.integers(span_ns))
    begin = time.monotonic()
    next(Recording(path).messages_between(at_ns, at_ns + span_ns))
    return (time.monotonic() - begin) * 1e3


def _replayed(case: str, path: Path) -> Iterator[Figure]:
    bus = InProcessHub().connect("replay", robot="replay")
    options = ReplayOptions(with_commands=True)
    with quick_switches():
        report = play(Recording(path), options, bus, RealClock(), threading.Event(), settle_s=0.0)
    for name, late_ms in report.values["late_ms"].items():
        yield Figure(case, f"replayed_late_{name}", [late_ms], "ms")


def _killed(
    directory: Path, seconds: float, kills: int, rng: np.random.Generator
) -> Iterator[Figure]:
    lost_bytes, lost_s = [], []
    for number in range(kills):
        path = directory / f"killed-{number}.mcap"
        sent, written = _kill_one(path, seconds, float(rng.uniform(0.3, 0.9)) * seconds)
        lost_bytes.append(float(sent - written))
        lost_s.append((sent - written) / KILLED_RATE)
    if kills:
        case = f"kill -9 at {KILLED_RATE * 1e-6:g} MB/s"
        yield Figure(case, "lost_bytes", lost_bytes, "bytes")
        yield Figure(case, "lost_time", lost_s, "s")
        yield Figure(case, "worst_lost_time", [max(lost_s)], "s")


def _kill_one(path: Path, seconds: float, after_s: float) -> tuple[int, int]:
    """Return the bytes of the messages that were sent, and of those that can be read."""
    tally = path.with_suffix(SENT_SUFFIX)
    process = subprocess.Popen(_command(path, KILLED_RATE, seconds), stdout=subprocess.DEVNULL)
    try:
        deadline = time.monotonic() + START_PATIENCE_S
        while not tally.exists():
            if process.poll() is not None or time.monotonic() > deadline:
                raise ProcessError("the recorder under load did not begin to record")
            time.sleep(0.02)
        time.sleep(after_s)
    finally:
        process.kill()
        process.wait()
    sent = int.from_bytes(tally.read_bytes(), "big")
    return sent, sum(len(one.payload) for one in Recording(path).messages(decode=False))


def _command(path: Path, bytes_per_s: float, seconds: float) -> list[str]:
    return [
        *(sys.executable, "-m", "w2c_recorder.bench.load", str(path)),
        *("--rate", str(bytes_per_s), "--seconds", str(seconds)),
    ]
