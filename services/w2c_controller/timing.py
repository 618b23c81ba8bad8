"""How well the loop keeps time."""

import numpy as np

KEPT = 2500
"""Ticks: the last five seconds."""
GAP_NS = 20_000_000


class Timing:
    """Rings of the last lateness and durations; adding does not allocate."""

    def __init__(self, period_ns: int) -> None:
        self._period_ns = period_ns
        self._lateness = np.zeros(KEPT)
        self._duration = np.zeros(KEPT)
        self._count = 0
        self._last_ns = -1
        self.gaps = 0
        """Intervals between two states of more than 20 ms, since the start"""

    def add(self, received_ns: int, begin_ns: int, end_ns: int) -> None:
        """Note a tick [ns, monotonic]: arrival of its state, begin and end of the work on it."""
        at = self._count % KEPT
        interval = begin_ns - self._last_ns if self._last_ns >= 0 else self._period_ns
        self._last_ns = begin_ns
        late = max(interval - self._period_ns, begin_ns - received_ns, 0)
        self._lateness[at] = late * 1e-3
        self._duration[at] = (end_ns - begin_ns) * 1e-3
        self._count += 1
        if interval > GAP_NS:
            self.gaps += 1

    def lateness_us(self) -> dict[str, float]:
        """Return p50, p99, max and the number of gaps."""
        kept = self._lateness[: min(self._count, KEPT)]
        if not kept.size:
            return {"p50": 0.0, "p99": 0.0, "max": 0.0, "gaps_20ms": 0.0}
        p50, p99 = np.percentile(kept, (50, 99))
        return {
            "p50": float(p50),
            "p99": float(p99),
            "max": float(kept.max()),
            "gaps_20ms": float(self.gaps),
        }

    def tick_us(self) -> dict[str, float]:
        """Return p50 and p99 of the time a tick takes."""
        kept = self._duration[: min(self._count, KEPT)]
        if not kept.size:
            return {"p50": 0.0, "p99": 0.0}
        p50, p99 = np.percentile(kept, (50, 99))
        return {"p50": float(p50), "p99": float(p99)}
