"""What requests cost lately, in one line for the health report."""

import statistics
import threading
from collections import deque

from w2c_grounding.timed import Times

_KEPT = 100


class Metrics:
    """Costs of the last requests. Thread-safe."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._answered = 0
        self._shared = 0
        self._queue_ms: deque[float] = deque(maxlen=_KEPT)
        self._times: deque[Times] = deque(maxlen=_KEPT)

    def answered(self, queue_ms: float, together: int) -> None:
        """Count an answer: how long its request waited, with how many it was answered."""
        with self._lock:
            self._answered += 1
            self._shared += together > 1
            self._queue_ms.append(queue_ms)

    def worked(self, times: Times) -> None:
        """Count one go of the model."""
        with self._lock:
            self._times.append(times)

    def summary(self) -> str:
        """Return counts, and medians of the last hundred; "" before the first answer."""
        with self._lock:
            queue, times = list(self._queue_ms), list(self._times)
            answered, shared = self._answered, self._shared
        if not queue or not times:
            return ""
        new = [one.prepare_ms for one in times if not one.known]
        picture = f"picture {statistics.median(new):.0f}, " if new else ""
        return (
            f"{answered} answers, {shared} of them with others; medians of the last {len(times)}: "
            f"queue {statistics.median(queue):.0f}, {picture}"
            f"phrases {statistics.median(one.query_ms for one in times):.0f} ms; "
            f"{100 * (len(times) - len(new)) / len(times):.0f} % of pictures known"
        )
