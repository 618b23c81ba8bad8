"""When the next state is due, and how late what comes is. Pure: it is told the time."""


class Cadence:
    """Absolute deadlines, one period apart, that follow the robot's own clock.

    A state cannot come before it was sent: one that comes early shows that the clock was behind,
    and is followed at once. One that comes late shows little, and is followed slowly.
    """

    FOLLOW = 4
    """Share of its lateness by which a late state moves the deadlines: one in so many."""
    ANEW = 2
    """A state that is later than so many periods starts the deadlines anew: the robot paused."""

    def __init__(self, period_ns: int) -> None:
        self._period_ns = period_ns
        self._start_ns: int | None = None
        self.due_ns = 0
        """When the next state is due [ns]."""
        self.deadline_ns = 0
        """When it is missed [ns]."""
        self.missed = 0
        """Periods at whose end no state had come."""

    def received(self, tick: int, now_ns: int) -> int:
        """Note the state of a tick; returns how late it was [ns]."""
        period = self._period_ns
        if self._start_ns is None:
            self._start_ns = now_ns - tick * period
        late = now_ns - (self._start_ns + tick * period)
        if late < 0 or late > self.ANEW * period:
            self._start_ns += late
        else:
            self._start_ns += late // self.FOLLOW
        self.due_ns = self._start_ns + (tick + 1) * period
        self.deadline_ns = self.due_ns + period
        return max(late, 0)

    def miss(self) -> None:
        """Note that the deadline passed without a state; the next one is a period later."""
        self.missed += 1
        self.deadline_ns += self._period_ns


class Transit:
    """How long messages were on their way, beyond the shortest way seen.

    Clocks of two hosts differ by a constant and drift apart slowly: the shortest way is forgotten
    at 100 ppm, faster than clocks drift.
    """

    FORGET = 10_000

    def __init__(self) -> None:
        self._shortest_ns: int | None = None
        self._last_ns = 0

    def age_ns(self, sent_ns: int, received_ns: int) -> int:
        """Return how much longer than the shortest this one was on its way [ns].

        Args:
            sent_ns: Monotonic clock of the sender.
            received_ns: Monotonic clock of the receiver.
        """
        way = received_ns - sent_ns
        if self._shortest_ns is None:
            self._shortest_ns = way
        else:
            forgotten = self._shortest_ns + (received_ns - self._last_ns) // self.FORGET
            self._shortest_ns = min(way, forgotten)
        self._last_ns = received_ns
        return way - self._shortest_ns
