"""`w2c replay FILE` from its flags to its report."""

import sys
import threading
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import msgspec

from w2c.bus import StandIn
from w2c.clock import Clock, RealClock
from w2c.errors import RecordingError
from w2c.service import stop_on_signals
from w2c.system import Connection, service_config
from w2c_recorder.reading import Recording
from w2c_recorder.replay.guard import REPLAY, Guard
from w2c_recorder.replay.namespace import Namespace
from w2c_recorder.replay.options import ReplayOptions
from w2c_recorder.replay.player import Played, Player
from w2c_recorder.replay.prefetch import prefetched
from w2c_recorder.replay.score import Score
from w2c_recorder.replay.selection import Selection, name_of
from w2c_recorder.report import Report

SWITCH_S = 0.0005
"""How long the thread that reads may keep the one that sends from running [s]"""


def play_on_bus(path: Path, options: ReplayOptions) -> Report:
    """Connect and play. Raises RecordingError, RefusedError, ConnectionFailedError."""
    recording = Recording(path)
    recording.read_metadata()  # a file that is none is told before anything else
    service = msgspec.structs.replace(
        service_config(
            Connection(robot=options.namespace, router=options.router, timeout=options.timeout)
        ),
        instance=uuid.uuid4().hex[:8],
    )
    stop = stop_on_signals()
    from w2c.bus.zenoh_bus import connect

    with connect(service, REPLAY, [service.router]) as bus, quick_switches():
        return play(recording, options, bus, RealClock(), stop)


def play(
    recording: Recording,
    options: ReplayOptions,
    bus: StandIn,
    clock: Clock,
    stop: threading.Event,
    settle_s: float = 1.0,
) -> Report:
    """Play a recording on a bus.

    Args:
        recording: what is played.
        options: how.
        bus: of the namespace.
        clock: of the deadlines.
        stop: ends it; what was played until then is reported.
        settle_s: how long to look for live robots before [s].

    Raises:
        RecordingError: nothing of the recording is to be played.
        RefusedError: a robot lives in the namespace, or came meanwhile.
    """
    namespace, selection = Namespace(bus.robot), Selection(options)
    score = Score(recording, selection, namespace, options.start_s, options.end_s)
    guard = Guard(bus, namespace, settle_s)
    guard.check_before()
    player = Player(bus, clock, speed=options.speed, keep_on=guard.check, stop=stop)
    try:
        while True:
            with prefetched(score.one_pass()) as dues:
                went_through = player.play(dues)
            if went_through and not player.played.messages:
                raise RecordingError(_why_nothing(recording, selection, options))
            if not (went_through and options.loop):
                break
    finally:
        player.leave()
    return _report(player.played, score, recording, options)


def _report(played: Played, score: Score, recording: Recording, options: ReplayOptions) -> Report:
    late = played.lateness.values_ms()
    passes = f" in {played.passes} passes" if played.passes > 1 else ""
    lines = [
        f"played as {options.namespace}: {played.messages} messages of {len(played.keys)} keys, "
        f"{played.bytes / 1e6:.1f} MB{passes}",
        f"calls answered as they were: {', '.join(sorted(played.answered)) or 'none'}",
        f"sent late: p50 {late['p50']:.2f}, p99 {late['p99']:.2f}, max {late['max']:.2f} ms",
        *score.left_out.lines(),
        *recording.damage.lines(),
    ]
    values = {
        "messages": played.messages,
        "bytes": played.bytes,
        "answered": sorted(played.answered),
        "late_ms": late,
    }
    return Report(lines, values)


def _why_nothing(recording: Recording, selection: Selection, options: ReplayOptions) -> str:
    """Say what there would have been."""
    if selection.seen:
        flags = f"--include {' '.join(options.include)}"
        if options.exclude:
            flags += f" --exclude {' '.join(options.exclude)}"
        commands = "" if options.with_commands else "; commands are played --with-commands only"
        return (
            f"{recording.path}: no message that can be played fits {flags}{commands}. "
            f"It holds: {', '.join(selection.seen)}"
        )
    keys, last_ns = set(), recording.start_ns
    for recorded in recording.messages(decode=False):
        keys.add(recorded.key)
        last_ns = max(last_ns, recorded.log_time_ns)
    if not any(name_of(key) for key in keys):
        others = ", ".join(sorted(keys | set(recording.elsewhere))[:5])
        problem = recording.damage.reason or "it was closed without one"
        return f"{recording.path} holds no message of this version: {others or problem}"
    until = "its end" if options.end_s is None else f"{options.end_s:g} s"
    return (
        f"{recording.path}: no message from {options.start_s:g} s to {until}; it is "
        f"{(last_ns - recording.start_ns) * 1e-9:.1f} s long"
    )


@contextmanager
def quick_switches() -> Iterator[None]:
    """Let the thread that sends run soon after it wakes up, whatever another one computes."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(SWITCH_S)
    try:
        yield
    finally:
        sys.setswitchinterval(before)
