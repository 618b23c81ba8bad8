"""States in real time: the newest one, by an absolute deadline."""

import time

from w2c.bus import Latest, Received
from w2c.messages import RobotState
from w2c_controller.loop.cadence import Cadence, Transit

EARLY_NS = 150_000
"""Before a state is due, the loop begins to look for it [ns]."""
LOOK_S = 50e-6
"""Between two looks [s]; the scheduler makes it a little more."""
IDLE_S = 0.002
"""Between two looks while nothing comes at all [s]."""
PATIENCE_S = 0.1


class StateFeed:
    """Waits for the next state of the robot, and knows how that went."""

    def __init__(self, latest: Latest[RobotState], period_ns: int, old_ns: int) -> None:
        """Begin without a state.

        Args:
            latest: The newest state, out of a ring of one.
            period_ns: Of the robot's ticks.
            old_ns: A state that was on its way for longer is not used.
        """
        self._latest = latest
        self._cadence = Cadence(period_ns)
        self._transit = Transit()
        self._old_ns = old_ns
        self._fresh_ns: int | None = None
        self.late_ns = 0
        """Of the last state, after it was due."""
        self.old = 0
        """States that were on their way for too long."""

    @property
    def missed(self) -> int:
        """Periods at whose end no state had come."""
        return self._cadence.missed

    def silence_ns(self) -> int:
        """Return the time since the last state that was used; 0 before the first."""
        return 0 if self._fresh_ns is None else time.monotonic_ns() - self._fresh_ns

    def next(self) -> Received[RobotState] | None:
        """Return the next state; None once its deadline has passed."""
        if self._fresh_ns is None:
            return self._use(self._latest.wait(PATIENCE_S))
        cadence = self._cadence
        self._sleep_until(cadence.due_ns - EARLY_NS)
        pause = LOOK_S if self.silence_ns() < 1_000_000_000 else IDLE_S
        while True:
            received = self._use(self._latest.take())
            if received is not None:
                return received
            if time.monotonic_ns() >= cadence.deadline_ns:
                cadence.miss()
                return None
            time.sleep(pause)

    def _use(self, received: Received[RobotState] | None) -> Received[RobotState] | None:
        """Return a state that is new enough, and note when it came."""
        if received is None:
            return None
        age_ns = self._transit.age_ns(received.envelope.monotonic_ns, received.received_ns)
        if age_ns > self._old_ns:
            self.old += 1
            return None
        self._fresh_ns = received.received_ns
        self.late_ns = self._cadence.received(received.message.tick, received.received_ns)
        return received

    @staticmethod
    def _sleep_until(deadline_ns: int) -> None:
        remaining = deadline_ns - time.monotonic_ns()
        if remaining > 0:
            time.sleep(remaining * 1e-9)
