"""How fast a machine goes, and how fast it could."""

from collections.abc import Callable

from w2c.clock import Clock


class Meter:
    """Measures since it was last read: robot time over wall time, and over time at work."""

    def __init__(self, clock: Clock, period_ns: int, processor_ns: Callable[[], int]) -> None:
        """Begin to measure.

        Args:
            clock: for the pace.
            period_ns: of a tick [ns].
            processor_ns: processor time of the thread that works [ns]: other processes that take
                the core away make a machine no slower than it is.
        """
        self._clock = clock
        self._processor_ns = processor_ns
        self._period_ns = period_ns
        self._since_ns = clock.now_ns()
        self._begun_ns = 0
        self._working_ns = 0
        self._ticks = 0

    def begin(self) -> None:
        """Begin the work of a tick."""
        self._begun_ns = self._processor_ns()

    def end(self) -> None:
        """End it."""
        self._working_ns += self._processor_ns() - self._begun_ns
        self._ticks += 1

    def read(self) -> tuple[float, float]:
        """Return pace and real-time factor since the last reading; 0 where no time went by.

        The pace is 1 in real time. The factor is what the pace would be with a core for the work
        alone.
        """
        now_ns = self._clock.now_ns()
        robot_ns = self._ticks * self._period_ns
        pace = robot_ns / max(now_ns - self._since_ns, 1) if now_ns > self._since_ns else 0.0
        factor = robot_ns / self._working_ns if self._working_ns else 0.0
        self._since_ns, self._working_ns, self._ticks = now_ns, 0, 0
        return pace, factor
