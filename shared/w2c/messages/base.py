"""What all messages share, and the messages every service sends."""

from typing import Annotated, Any

import msgspec
import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]

_FLOAT64 = np.dtype(np.float64)

# Bounds that keep a hostile or broken sender from filling a receiver's memory.
Text = Annotated[str, msgspec.Meta(max_length=20_000)]
Name = Annotated[str, msgspec.Meta(min_length=1, max_length=100)]
Stamp = Annotated[int, msgspec.Meta(ge=0)]
RobotBoot = Annotated[str, msgspec.Meta(max_length=64)]
"""Boot id of the robot's process. One that started anew counts time from zero again, so that a
stamp alone may be that of another frame. "" = not known, so not checked"""


class Message(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, eq=False):
    """Base of every message. Compare encoded bytes, not structs: arrays have no ==."""


def all_finite(value: Array) -> bool:
    """Tell whether no number is NaN or infinite."""
    # A search in bytes takes half the time of `.all()`, and this runs at every tick.
    return b"\0" not in np.isfinite(value).tobytes()


def check_array(
    name: str,
    value: Array,
    shape: tuple[int | None, ...],
    *,
    finite: bool = True,
    dtype: npt.DTypeLike = _FLOAT64,
) -> None:
    """Raise ValueError unless dtype, shape (None = any length) and finiteness are right."""
    if value.dtype != dtype:
        raise ValueError(f"{name}: dtype {value.dtype}, expected {np.dtype(dtype)}")
    # Most shapes are wanted exactly; lengths one by one take five times as long.
    if value.shape != shape and not _fits(value.shape, shape):
        raise ValueError(f"{name}: shape {value.shape}, expected {shape} (None = any length)")
    if finite and not all_finite(value):
        raise ValueError(f"{name}: holds NaN or infinity, expected finite numbers")


def _fits(have: tuple[int, ...], wanted: tuple[int | None, ...]) -> bool:
    if len(have) != len(wanted):
        return False
    # A loop: a generator takes twice as long, and this runs at every tick.
    for length, want in zip(have, wanted, strict=True):
        if want is not None and length != want:
            return False
    return True


class Empty(Message, frozen=True, kw_only=True):
    """A request without parameters, or a reply that only says that it was done."""


class ErrorReply(Message, frozen=True, kw_only=True):
    """Why a call gave no result. `code` is one of `w2c.errors.error_codes()`."""

    code: Name
    message: Text
    retryable: bool = False


class Health(Message, frozen=True, kw_only=True):
    """The state of one process, published once a second."""

    stamp_ns: Stamp
    service: Name
    instance: Name
    phase: Name
    """configure, ready, drain or failed."""
    detail: Text = ""
    """What the process is doing, or why it is not ready; for people."""
    pid: int
    cpu_percent: float
    """Share of one core [%], since the last report."""
    memory_mb: float
    queue_length: int = 0
    """Requests that wait in this replica."""
    counters: dict[str, int] = {}
    """Drops and refusals since the start, by cause (late, malformed, unreachable ...)."""
    facts: dict[str, Text] = {}
    """What the process is, the same in each report: configuration, checksum of its model."""


class LogRecord(Message, frozen=True, kw_only=True):
    """One line of a log."""

    stamp_ns: Stamp
    level: Name
    logger: Name
    text: Text
    fields: dict[str, str] = {}


class CallTrace(Message, frozen=True, kw_only=True):
    """One call from one service to another, published by the caller. Time-outs are traced too."""

    service: Name
    method: Name
    instance: str
    outcome: Name
    """ok, or the code of the error."""
    duration_ms: float
    request: bytes
    """The encoded request."""
    reply: bytes
    """The encoded reply; empty where none came."""
    error: Text = ""


class ProcessState(Message, frozen=True, kw_only=True):
    """One row of the launcher's table."""

    name: Name
    phase: Name
    """starting, ready, restarting, failed or stopped."""
    pid: int | None
    restarts: int
    detail: Text = ""


class ProcessTable(Message, frozen=True, kw_only=True):
    """What the launcher looks after."""

    stamp_ns: Stamp
    run_directory: Text
    processes: list[ProcessState]
