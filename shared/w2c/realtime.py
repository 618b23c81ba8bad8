"""What a loop with deadlines asks of Linux: memory that stays in memory, and precedence.

Neither is granted everywhere. A loop runs without them, later now and then; whoever looks at the
process is told.
"""

import ctypes
import gc
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

CONTROLLER_PRIORITY: Final = 40
ROBOT_PRIORITY: Final = 45
"""Below the kernel's own interrupt threads (50); the driver before who commands it."""

ENOUGH_CORES: Final = 4
"""With fewer, two loops that go before everything starve the models beside them."""

Setting = Literal["auto", "on", "off"]
"""Of `--real-time`: ask only where there are enough cores; ask; do not ask."""

_MCL_CURRENT, _MCL_FUTURE, _MCL_ONFAULT = 1, 2, 4
_TASKS = Path("/proc/self/task")


@dataclass(frozen=True)
class RealTime:
    """What was granted."""

    memory_locked: bool
    priority: bool
    trouble: str
    """For people: what was not, why, and what grants it; "" = all was"""


NOT_ASKED: Final = RealTime(False, False, "")


@contextmanager
def real_time(priority: int, setting: Setting = "on") -> Iterator[RealTime]:
    """Lock this process's memory and run its present threads under SCHED_FIFO, where granted.

    All threads that exist get the priority, those of the bus too: a state that waits for them is as
    late as a loop that does not run. Threads that they start later do not.

    Args:
        priority: Of SCHED_FIFO, 1 to 99.
        setting: "auto" leaves the scheduler alone on a host with too few cores.
    """
    if setting == "off":
        yield NOT_ASKED
        return
    troubles = []
    locked = _lock_memory()
    if locked:
        troubles.append(f"memory is not locked ({locked}): grant CAP_IPC_LOCK, or raise ulimit -l")
    cores = len(os.sched_getaffinity(0))
    refused = ""
    if setting == "auto" and cores < ENOUGH_CORES:
        refused = f"{cores} cores, {ENOUGH_CORES} are enough"
        troubles.append(f"no SCHED_FIFO ({refused}): the models would starve; --real-time on asks")
    elif refused := _raise_priority(priority):
        troubles.append(f"no SCHED_FIFO ({refused}): grant CAP_SYS_NICE, or raise ulimit -r")
    try:
        yield RealTime(not locked, not refused, "; ".join(troubles))
    finally:
        _libc().munlockall()
        for task in _tasks():
            _schedule(task, os.SCHED_OTHER, 0)


@contextmanager
def collector_off() -> Iterator["CollectorWatch"]:
    """Keep the garbage collector from running while the block runs, and prove it.

    What was built before lives as long as the process: it is frozen, so that a collection by hand
    would not look at it again. Reference counts free what a loop drops.
    """
    was_enabled = gc.isenabled()
    gc.collect()
    gc.freeze()
    gc.disable()
    watch = CollectorWatch()
    gc.callbacks.append(watch)
    try:
        yield watch
    finally:
        gc.callbacks.remove(watch)
        gc.unfreeze()
        if was_enabled:
            gc.enable()


class CollectorWatch:
    """Counts runs of the garbage collector."""

    def __init__(self) -> None:
        self.runs = 0

    def __call__(self, phase: Literal["start", "stop"], _info: dict[str, int]) -> None:
        """Take a call of the collector."""
        self.runs += phase == "start"


def _lock_memory() -> str:
    """Return why it was refused; "" = granted."""
    # Pages that were never touched are not brought in: stacks of idle threads are large.
    if _libc().mlockall(_MCL_CURRENT | _MCL_FUTURE | _MCL_ONFAULT) == 0:
        return ""
    return os.strerror(ctypes.get_errno())


def _raise_priority(priority: int) -> str:
    """Return why it was refused; "" = granted."""
    refused = ""
    for task in _tasks():
        refused = _schedule(task, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, priority) or refused
    return refused


def _schedule(task: int, policy: int, priority: int) -> str:
    """Return why a thread was not scheduled so; "" = it is, or it ended meanwhile."""
    try:
        os.sched_setscheduler(task, policy, os.sched_param(priority))
    except ProcessLookupError:
        return ""
    except OSError as error:
        return error.strerror or str(error)
    return ""


def _tasks() -> list[int]:
    return [int(entry.name) for entry in _TASKS.iterdir()]


def _libc() -> ctypes.CDLL:
    return ctypes.CDLL(None, use_errno=True)
