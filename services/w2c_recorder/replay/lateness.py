"""How late messages were sent."""

import numpy as np

from w2c.percentiles import percentiles

KEPT = 1_000_000


class Lateness:
    """Of the last million messages, and the worst of all."""

    def __init__(self) -> None:
        self._late_ns = np.zeros(1024)
        self.count = 0
        self.worst_ns = 0

    def add(self, late_ns: int) -> None:
        """Note one message."""
        size = len(self._late_ns)
        if self.count >= size and size < KEPT:
            self._late_ns = np.concatenate([self._late_ns, np.zeros(min(size, KEPT - size))])
        self._late_ns[self.count % len(self._late_ns)] = late_ns
        self.count += 1
        self.worst_ns = max(self.worst_ns, late_ns)

    def values_ms(self) -> dict[str, float]:
        """Return p50, p99 and max [ms]."""
        kept = self._late_ns[: min(self.count, len(self._late_ns))] * 1e-6
        return {**percentiles(kept), "max": self.worst_ns * 1e-6}
