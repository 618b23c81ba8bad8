"""Keep a loop on absolute deadlines, and know how well that went."""

import numpy as np

from w2c.clock import Clock
from w2c.percentiles import percentiles

_LONGEST_BACKLOG_NS = 20_000_000
_KEPT = 5000


class Pacer:
    """Deadlines one period apart.

    A loop that comes late catches up without a pause; one that is more than 20 ms behind does not:
    robot time then falls behind the wall clock for good, and that is counted.
    """

    def __init__(self, clock: Clock, period_ns: int) -> None:
        self._clock = clock
        self._period_ns = period_ns
        self._deadline_ns = clock.now_ns()
        self._lateness_ns = np.zeros(_KEPT)
        self._count = 0
        self.late = 0
        """Periods that began more than a period after they were due."""
        self.gaps = 0
        """How often the loop was more than 20 ms late."""

    def wait(self) -> bool:
        """Wait for the next deadline. Returns False if it was missed by more than 20 ms."""
        self._deadline_ns += self._period_ns
        self._clock.sleep_until(self._deadline_ns)
        late_ns = max(0, self._clock.now_ns() - self._deadline_ns)
        self._lateness_ns[self._count % _KEPT] = late_ns
        self._count += 1
        self.late += late_ns > self._period_ns
        if late_ns <= _LONGEST_BACKLOG_NS:
            return True
        self.gaps += 1
        self._deadline_ns += late_ns
        return False

    def lateness_us(self) -> dict[str, float]:
        """Return p50, p99 and max of the last 5000 periods [us], and the number of gaps."""
        kept = self._lateness_ns[: min(self._count, _KEPT)] * 1e-3
        return {
            **percentiles(kept),
            "max": float(kept.max()) if kept.size else 0.0,
            "gaps_20ms": float(self.gaps),
        }
