"""How well the loop keeps time."""

from bisect import bisect_left

import numpy as np

from w2c.percentiles import percentiles

KEPT = 2500
"""Ticks: the last five seconds."""
GAP_NS = 20_000_000
BIN_EDGES_US = (
    25.0, 50.0, 75.0, 100.0, 150.0, 200.0, 300.0, 500.0, 750.0,
    1000.0, 1500.0, 2000.0, 3000.0, 5000.0, 10_000.0, 20_000.0,
)  # fmt: skip
"""Upper edges of the bins of both histograms; one more is above the last."""


class Timing:
    """Rings of the last lateness and durations, and histograms since the start.

    Adding does not allocate.
    """

    def __init__(self, period_ns: int) -> None:
        self._period_ns = period_ns
        self._lateness = np.zeros(KEPT)
        self._duration = np.zeros(KEPT)
        self._last_ns = -1
        self.lateness_counts = np.zeros(len(BIN_EDGES_US) + 1, dtype=np.int64)
        self.duration_counts = np.zeros(len(BIN_EDGES_US) + 1, dtype=np.int64)
        self.lateness_max_us = 0.0
        self.duration_max_us = 0.0
        self.ticks = 0
        self.gaps = 0
        """Intervals between two states of more than 20 ms, since the start"""

    def add(self, late_ns: int, begin_ns: int, end_ns: int) -> None:
        """Note a tick [ns, monotonic].

        Args:
            late_ns: How late its state came, after it was due.
            begin_ns: Of the work on it.
            end_ns: Of the work on it.
        """
        at = self.ticks % KEPT
        interval = begin_ns - self._last_ns if self._last_ns >= 0 else self._period_ns
        self._last_ns = begin_ns
        late = max(interval - self._period_ns, late_ns) * 1e-3
        duration = (end_ns - begin_ns) * 1e-3
        self._lateness[at] = late
        self._duration[at] = duration
        self.lateness_counts[bisect_left(BIN_EDGES_US, late)] += 1
        self.duration_counts[bisect_left(BIN_EDGES_US, duration)] += 1
        self.lateness_max_us = max(self.lateness_max_us, late)
        self.duration_max_us = max(self.duration_max_us, duration)
        self.ticks += 1
        if interval > GAP_NS:
            self.gaps += 1

    def lateness_us(self) -> dict[str, float]:
        """Return p50, p99, max and the number of gaps."""
        kept = self._lateness[: min(self.ticks, KEPT)]
        return {
            **percentiles(kept),
            "max": float(kept.max()) if kept.size else 0.0,
            "gaps_20ms": float(self.gaps),
        }

    def tick_us(self) -> dict[str, float]:
        """Return p50 and p99 of the time a tick takes."""
        return percentiles(self._duration[: min(self.ticks, KEPT)])
