"""Clocks are arguments, so that tests and lock step need no waiting."""

import time
from typing import Protocol


class Clock(Protocol):
    """Time of one process."""

    def now_ns(self) -> int:
        """Return the monotonic time [ns]."""

    def sleep_until(self, deadline_ns: int) -> None:
        """Return at the deadline of this clock, at once if it has passed."""


class RealClock:
    """The machine's monotonic clock."""

    def now_ns(self) -> int:
        """Return the monotonic time [ns]."""
        return time.monotonic_ns()

    def sleep_until(self, deadline_ns: int) -> None:
        """Sleep to an absolute deadline: a relative sleep would drift."""
        remaining = deadline_ns - time.monotonic_ns()
        if remaining > 0:
            time.sleep(remaining * 1e-9)


class StepClock:
    """A clock that its owner advances: for tests, and for lock step."""

    def __init__(self, start_ns: int = 0) -> None:
        self._now_ns = start_ns

    def now_ns(self) -> int:
        """Return the time it was last set to [ns]."""
        return self._now_ns

    def sleep_until(self, deadline_ns: int) -> None:
        """Jump to the deadline."""
        self.set(max(self._now_ns, deadline_ns))

    def set(self, now_ns: int) -> None:
        """Move forward to `now_ns`. Raises ValueError for a step back."""
        if now_ns < self._now_ns:
            raise ValueError(f"clock cannot go back from {self._now_ns} ns to {now_ns} ns")
        self._now_ns = now_ns
