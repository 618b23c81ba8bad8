"""Whether a recording keeps a budget: rates, jitter, ages, losses, calls and the control loop."""

from array import array
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from w2c import messages as m
from w2c import topics
from w2c_recorder.budget import Budget
from w2c_recorder.losses import LossCounter
from w2c_recorder.mcap_file import head_of
from w2c_recorder.reading import Recorded, Recording, decode_call, topic_of

FEWEST_FOR_A_RATE = 3
FEWEST_FOR_A_PERCENTILE = 10
ROBOT_TIME = ("robot", "controller", "camera", "perception")
"""Services whose rates count in robot time"""


@dataclass(frozen=True)
class Finding:
    """One figure that was held against a limit."""

    subject: str
    """Stream as kind/service/name, call as service/method, or loop"""
    figure: str
    value: float
    limit: float
    unit: str
    kept: bool

    def text(self) -> str:
        """Return the finding for people."""
        verdict = "ok  " if self.kept else "FAIL"
        unit = f" {self.unit}" if self.unit else ""
        return (
            f"{verdict} {self.subject:<28} {self.figure:<18} {self.value:.4g}{unit}, "
            f"limit {self.limit:.4g}{unit}"
        )


@dataclass
class _Stream:
    arrivals_ns: "array[int]" = field(default_factory=lambda: array("q"))
    ages_ns: "array[int]" = field(default_factory=lambda: array("q"))
    malformed: int = 0
    lost: int = 0


@dataclass
class _Calls:
    durations_ms: list[float] = field(default_factory=list)
    failed: int = 0


@dataclass
class Figures:
    """What was measured in a recording."""

    streams: dict[str, _Stream] = field(default_factory=dict)
    calls: dict[str, _Calls] = field(default_factory=dict)
    losses: LossCounter = field(default_factory=LossCounter)
    loops: list[m.ControllerStatistics] = field(default_factory=list)
    """The last report of each run of the controller"""
    paces: list[float] = field(default_factory=list)
    lock_step: bool = False
    end_ns: int = 0

    @property
    def pace(self) -> float:
        """Robot time over wall time that is to be expected: 1 but in lock step, which waits."""
        return float(np.median(self.paces)) if self.lock_step and self.paces else 1.0


def measure(recording: Recording) -> Figures:
    """Read a recording once. Raises RecordingError."""
    figures = Figures()
    for recorded in recording.messages(decode=False):
        figures.end_ns = max(figures.end_ns, recorded.log_time_ns)
        if recorded.topic is None:
            continue
        _count(figures, recorded)
        if recorded.topic in (topics.TRACE, topics.CONTROLLER_STATISTICS, topics.ROBOT_STATISTICS):
            _look_into(figures, recorded.decoded().message)
    for key, lost in figures.losses.lost().items():
        figures.streams[name_of(key)].lost += lost
    return figures


def name_of(key: str) -> str:
    """Return kind/service/name of a key."""
    return "/".join(key.split("/")[3:])


def _count(figures: Figures, recorded: Recorded) -> None:
    stream = figures.streams.setdefault(name_of(recorded.key), _Stream())
    stream.arrivals_ns.append(recorded.log_time_ns)
    head = head_of(recorded.payload)
    if head is None:
        stream.malformed += 1
        return
    stream.ages_ns.append(recorded.log_time_ns - recorded.publish_time_ns)
    figures.losses.observe(recorded.key, head.boot_id, head.sequence)


def _look_into(figures: Figures, message: m.Message | None) -> None:
    if isinstance(message, m.RobotStatistics):
        figures.paces.append(message.pace)
    elif isinstance(message, m.ControllerStatistics):
        if not figures.loops or message.ticks < figures.loops[-1].ticks:
            figures.loops.append(message)  # a controller that started anew counts from zero
        else:
            figures.loops[-1] = message
    elif isinstance(message, m.CallTrace):
        calls = figures.calls.setdefault(f"{message.service}/{message.method}", _Calls())
        if message.outcome == "ok":
            calls.durations_ms.append(message.duration_ms)
        elif message.outcome != "refused":
            calls.failed += 1
        if (message.service, message.method) == (topics.DESCRIBE.service, topics.DESCRIBE.name):
            reply = decode_call(message)[1]
            figures.lock_step |= isinstance(reply, m.RobotDescription) and reply.lock_step


def findings(figures: Figures, budget: Budget) -> Iterator[Finding]:
    """Yield every figure that the budget limits: streams, then calls, then the loop."""
    for name, stream in sorted(figures.streams.items()):
        yield from _stream_findings(name, stream, figures, budget)
    for name, calls in sorted(figures.calls.items()):
        limits = budget.of_call(name)
        yield from _most(name, "failed", calls.failed, limits.failed_max)
        if calls.durations_ms:
            p95 = float(np.percentile(calls.durations_ms, 95))
            yield from _most(name, "duration p95", p95, limits.p95_max_ms, "ms")
    for name in sorted({*budget.streams} - {*figures.streams}):
        yield Finding(name, "messages", 0.0, 1.0, "", kept=False)  # limited, and not there
    yield from _loop_findings(figures, budget)


def _stream_findings(
    name: str, stream: _Stream, figures: Figures, budget: Budget
) -> Iterator[Finding]:
    limits = budget.of_stream(name)
    arrivals = np.asarray(stream.arrivals_ns, dtype=np.int64)
    yield from _most(name, "lost", stream.lost, limits.lost_max)
    yield from _most(name, "malformed", stream.malformed, limits.malformed_max)
    yield from _least_rate(name, arrivals, figures, limits.rate_min)
    gaps_ms = np.diff(arrivals) * 1e-6
    if len(gaps_ms):
        yield from _most(name, "longest gap", float(gaps_ms.max()), limits.gap_max_ms, "ms")
    if len(gaps_ms) >= FEWEST_FOR_A_PERCENTILE:
        jitter = float(np.percentile(np.abs(gaps_ms - np.median(gaps_ms)), 99))
        yield from _most(name, "jitter p99", jitter, limits.jitter_p99_max_ms, "ms")
    if len(stream.ages_ns) >= FEWEST_FOR_A_PERCENTILE:
        age_ms = float(np.percentile(np.asarray(stream.ages_ns) * 1e-6, 99))
        yield from _most(name, "age p99", age_ms, limits.age_p99_max_ms, "ms")
    silent_s = (figures.end_ns - int(arrivals[-1])) * 1e-9
    yield from _most(name, "silent at the end", silent_s, limits.silent_end_max_s, "s")


def _least_rate(
    name: str, arrivals: npt.NDArray[np.int64], figures: Figures, share: float | None
) -> Iterator[Finding]:
    row = topic_of(f"w2c/{topics.VERSION}/robot/{name}")
    if share is None or row is None or not row.rate_hz or len(arrivals) < FEWEST_FOR_A_RATE:
        return
    span_s = (int(arrivals[-1]) - int(arrivals[0])) * 1e-9
    rate = (len(arrivals) - 1) / span_s if span_s > 0 else 0.0
    pace = figures.pace if row.service in ROBOT_TIME else 1.0
    limit = share * row.rate_hz * pace
    yield Finding(name, "rate", rate, limit, "Hz", kept=rate >= limit)


def _loop_findings(figures: Figures, budget: Budget) -> Iterator[Finding]:
    if not figures.loops:
        return
    limits, loops = budget.loop, figures.loops
    missed = sum(one.missed_deadlines for one in loops)
    gaps = sum(one.gaps_20ms for one in loops)
    failures = sum(one.retargeting.failures + one.force_control.failures for one in loops)
    if not figures.lock_step:  # nothing is due in lock step
        yield from _most("loop", "missed deadlines", missed, limits.missed_deadlines_max)
        yield from _most("loop", "gaps over 20 ms", gaps, limits.gaps_20ms_max)
    yield from _most("loop", "solver failures", failures, limits.solver_failures_max)


def _most(
    subject: str, figure: str, value: float, limit: float | None, unit: str = ""
) -> Iterator[Finding]:
    if limit is not None:
        yield Finding(subject, figure, float(value), float(limit), unit, kept=value <= limit)
