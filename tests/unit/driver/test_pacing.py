"""A loop on absolute deadlines."""

from w2c.clock import StepClock
from w2c.driver.pacing import Pacer

PERIOD_NS = 2_000_000


def test_deadlines_do_not_drift() -> None:
    clock = StepClock(1_000)
    pacer = Pacer(clock, PERIOD_NS)
    for _ in range(10):
        clock.set(clock.now_ns() + 700_000)  # work
        assert pacer.wait()
    assert clock.now_ns() == 1_000 + 10 * PERIOD_NS
    assert pacer.lateness_us() == {"p50": 0.0, "p99": 0.0, "max": 0.0, "gaps_20ms": 0.0}


def test_a_late_loop_catches_up() -> None:
    clock = StepClock()
    pacer = Pacer(clock, PERIOD_NS)
    clock.set(7_000_000)
    assert pacer.wait()
    assert pacer.lateness_us()["max"] == 5000.0
    for _ in range(3):
        pacer.wait()
    assert clock.now_ns() == 8_000_000


def test_a_loop_far_behind_gives_the_time_up_and_counts_it() -> None:
    clock = StepClock()
    pacer = Pacer(clock, PERIOD_NS)
    clock.set(100_000_000)
    assert not pacer.wait()
    assert pacer.gaps == 1
    assert pacer.wait()
    assert clock.now_ns() == 102_000_000
    assert pacer.lateness_us()["gaps_20ms"] == 1.0


def test_no_period_no_lateness() -> None:
    assert Pacer(StepClock(), PERIOD_NS).lateness_us()["max"] == 0.0
