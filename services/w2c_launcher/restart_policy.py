"""When a dead process is started again, and when it is given up."""

from collections import deque


class RestartPolicy:
    """Back-off that doubles, and a limit on deaths within a window."""

    def __init__(
        self,
        first_delay_s: float = 0.5,
        longest_delay_s: float = 8.0,
        limit: int = 5,
        window_s: float = 60.0,
    ) -> None:
        self._first_delay_s = first_delay_s
        self._longest_delay_s = longest_delay_s
        self._limit = limit
        self._window_s = window_s
        self._deaths: deque[float] = deque()
        self.restarts = 0

    def died(self, now_s: float) -> float | None:
        """Return the delay before the next start [s]; None = give up."""
        self._deaths.append(now_s)
        while self._deaths and now_s - self._deaths[0] > self._window_s:
            self._deaths.popleft()
        if len(self._deaths) > self._limit:
            return None
        self.restarts += 1
        delay: float = self._first_delay_s * 2.0 ** (len(self._deaths) - 1)
        return min(delay, self._longest_delay_s)
