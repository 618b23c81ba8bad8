"""What a recording is held against: limits on rates, ages, jitter, losses and deadlines."""

from pathlib import Path
from typing import Annotated, TypeVar

import msgspec

from w2c import topics
from w2c.config import load, read_toml
from w2c.errors import ConfigError

Limit = Annotated[float, msgspec.Meta(ge=0.0)]


class StreamLimits(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Limits of one stream. None = not checked."""

    rate_min: Limit | None = None
    """Messages a second, as a share of the nominal rate"""
    gap_max_ms: Limit | None = None
    """Longest time between two messages [ms]"""
    jitter_p99_max_ms: Limit | None = None
    """How far intervals are from their median, 99 of 100 [ms]"""
    age_p99_max_ms: Limit | None = None
    """From sender to recorder, 99 of 100, by the clocks of both hosts [ms]"""
    lost_max: int | None = None
    malformed_max: int | None = None
    silent_end_max_s: Limit | None = None
    """Between its last message and the end of the recording [s]"""


class CallLimits(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Limits of one method. None = not checked."""

    failed_max: int | None = None
    """Calls without a result, refusals left out: those are answers"""
    p95_max_ms: Limit | None = None
    """95 of 100 take at most this long [ms]"""


class LoopLimits(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Limits of the control loop over the whole recording. None = not checked."""

    missed_deadlines_max: int | None = None
    gaps_20ms_max: int | None = None
    solver_failures_max: int | None = None


class Budget(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """All limits: a table for all streams and calls, and tables for some.

    Keys are as in the reference of messages: "state/robot/joints", "llm/complete". What a stream's
    own table leaves out is taken from the table for all.
    """

    stream: StreamLimits = StreamLimits(rate_min=0.8, lost_max=0, malformed_max=0)
    call: CallLimits = CallLimits(failed_max=0)
    loop: LoopLimits = LoopLimits(missed_deadlines_max=0, gaps_20ms_max=0)
    streams: dict[str, StreamLimits] = {}
    calls: dict[str, CallLimits] = {}

    def of_stream(self, name: str) -> StreamLimits:
        """Return the limits of kind/service/name."""
        return _merged(self.stream, self.streams.get(name))

    def of_call(self, name: str) -> CallLimits:
        """Return the limits of service/method."""
        return _merged(self.call, self.calls.get(name))


def read_budget(path: Path) -> Budget:
    """Return the budget of a TOML file. Raises ConfigError with what is wrong in it."""
    budget = load(Budget, read_toml(path))
    known = {f"{method.service}/{method.name}" for method in topics.METHODS}
    for name in sorted(budget.calls.keys() - known):
        raise ConfigError(
            f"{path}: there is no call '{name}'; choose one of: {', '.join(sorted(known))}"
        )
    return budget


L = TypeVar("L", StreamLimits, CallLimits)


def _merged(common: L, own: L | None) -> L:
    if own is None:
        return common
    given = {
        name: getattr(own, name) for name in own.__struct_fields__ if getattr(own, name) is not None
    }
    return msgspec.structs.replace(common, **given)
