"""How fast a machine goes, and how fast it could."""

from w2c.clock import Clock


class Meter:
    """Measures since it was last read: robot time over wall time, and over time at work."""

    def __init__(self, clock: Clock, period_ns: int) -> None:
        self._clock = clock
        self._period_ns = period_ns
        self._begun_ns = self._since_ns = clock.now_ns()
        self._working_ns = 0
        self._ticks = 0

    def begin(self) -> None:
        """Begin the work of a tick."""
        self._begun_ns = self._clock.now_ns()

    def end(self) -> None:
        """End it."""
        self._working_ns += self._clock.now_ns() - self._begun_ns
        self._ticks += 1

    def read(self) -> tuple[float, float]:
        """Return pace and real-time factor since the last reading; 0 where no time went by.

        The pace is 1 in real time. The factor is what the pace would be without any waiting.
        """
        now_ns = self._clock.now_ns()
        robot_ns = self._ticks * self._period_ns
        pace = robot_ns / max(now_ns - self._since_ns, 1) if now_ns > self._since_ns else 0.0
        factor = robot_ns / self._working_ns if self._working_ns else 0.0
        self._since_ns, self._working_ns, self._ticks = now_ns, 0, 0
        return pace, factor
