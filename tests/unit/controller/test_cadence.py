"""Deadlines that follow the robot's clock, and ages that forgive clocks that differ."""

import numpy as np

from support.states import standing_state
from w2c.bus.codec import Envelope
from w2c.bus.interface import Received
from w2c.messages import RobotDescription, RobotState
from w2c_controller.loop.cadence import Cadence, Transit
from w2c_controller.loop.feed import StateFeed

PERIOD = 2_000_000
US = 1_000


def test_deadlines_are_one_period_apart_however_late_states_come() -> None:
    cadence, jitter = Cadence(PERIOD), np.random.default_rng(0)
    late = [
        cadence.received(tick, 5_000_000 + tick * PERIOD + int(jitter.integers(0, 300)) * US)
        for tick in range(5000)
    ]
    assert max(late) < 301 * US
    assert abs(cadence.due_ns - (5_000_000 + 5000 * PERIOD)) < 200 * US
    assert cadence.deadline_ns == cadence.due_ns + PERIOD


def test_a_late_state_is_told_and_hardly_moves_the_deadlines() -> None:
    cadence = Cadence(PERIOD)
    for tick in range(100):
        cadence.received(tick, tick * PERIOD)
    assert cadence.received(100, 100 * PERIOD + 800 * US) == 800 * US
    assert cadence.due_ns == 101 * PERIOD + 200 * US
    assert cadence.received(101, 101 * PERIOD) == 0
    assert cadence.due_ns == 102 * PERIOD


def test_a_robot_that_paused_starts_the_deadlines_anew() -> None:
    cadence = Cadence(PERIOD)
    cadence.received(0, 0)
    assert cadence.received(1, 50_000_000) == 48_000_000
    assert cadence.received(2, 52_000_000) == 0


def test_each_period_without_a_state_is_counted() -> None:
    cadence = Cadence(PERIOD)
    cadence.received(0, 0)
    first = cadence.deadline_ns
    for _ in range(3):
        cadence.miss()
    assert cadence.missed == 3
    assert cadence.deadline_ns == first + 3 * PERIOD
    cadence.received(4, 4 * PERIOD)
    assert cadence.deadline_ns == 6 * PERIOD


def test_an_age_is_the_way_beyond_the_shortest_whatever_the_clocks_say() -> None:
    for offset in (0, 10**15, -(10**15)):
        transit = Transit()
        assert transit.age_ns(0, offset + 300 * US) == 0
        assert transit.age_ns(PERIOD, offset + PERIOD + 200 * US) == 0
        assert (
            abs(transit.age_ns(2 * PERIOD, offset + 60_000_000 + 2 * PERIOD) - 59_800_000) < 10_000
        )


def test_clocks_may_drift_apart() -> None:
    transit = Transit()
    ages = [transit.age_ns(k * PERIOD, k * PERIOD + k * PERIOD // 20_000) for k in range(100_000)]
    assert max(ages) < 10 * US


class Slot:
    """A ring of one that holds what it is given."""

    def __init__(self) -> None:
        self.waiting: list[Received[RobotState]] = []

    def take(self) -> Received[RobotState] | None:
        return self.waiting.pop(0) if self.waiting else None

    def wait(self, timeout_s: float) -> Received[RobotState] | None:
        return self.take()

    def last(self) -> None:
        return None

    def age_s(self) -> float:
        return 0.0


def received(state: RobotState, sent_ns: int, received_ns: int) -> Received[RobotState]:
    envelope = Envelope(1, "test", "robot", "boot", 0, sent_ns, 0, [], None)
    return Received(message=state, key="k", envelope=envelope, received_ns=received_ns)


def test_a_state_that_was_long_on_its_way_is_not_used(description: RobotDescription) -> None:
    slot = Slot()
    feed = StateFeed(slot, PERIOD, old_ns=50_000_000)
    state = standing_state(description)
    slot.waiting = [received(state, 0, 100), received(state, PERIOD, PERIOD + 60_000_000)]
    assert feed.next() is not None
    assert feed.next() is None
    assert feed.old == 1
    assert feed.missed >= 1


def test_a_deadline_without_a_state_is_counted(description: RobotDescription) -> None:
    slot = Slot()
    feed = StateFeed(slot, PERIOD, old_ns=50_000_000)
    slot.waiting = [received(standing_state(description), 0, 100)]
    assert feed.silence_ns() == 0
    feed.next()
    assert [feed.next() for _ in range(3)] == [None] * 3
    assert feed.missed == 3
    assert feed.silence_ns() > 0
