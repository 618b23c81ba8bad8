"""Whether something that should move still does."""

import numpy as np

from w2c_controller.loop.timing import KEPT, Timing
from w2c_controller.parameters import Motion
from w2c_controller.switching.stall import StallDetector


def test_a_slow_motion_is_no_stall_and_a_rest_is() -> None:
    stall = StallDetector(Motion(), 0.01)
    position = np.zeros(3)
    for _ in range(600):
        position += np.array([0.00002, 0.0, 0.0])  # 2 mm/s
        assert not stall.step(position)
    results = [stall.step(position) for _ in range(210)]
    assert not results[100]
    assert results[-1]
    stall.reset()
    assert not stall.step(position)


def test_timing_counts_gaps_and_keeps_the_newest() -> None:
    timing = Timing(2_000_000)
    now = 0
    for _ in range(KEPT + 10):
        timing.add(0, now, now + 300_000)
        now += 2_000_000
    assert timing.lateness_us() == {"p50": 0.0, "p99": 0.0, "max": 0.0, "gaps_20ms": 0.0}
    assert timing.tick_us() == {"p50": 300.0, "p99": 300.0}
    now += 30_000_000
    timing.add(0, now, now + 300_000)
    assert timing.lateness_us()["max"] == 30_000.0
    assert timing.gaps == 1


def test_timing_without_a_tick_is_zero() -> None:
    assert Timing(2_000_000).lateness_us()["max"] == 0.0
    assert Timing(2_000_000).tick_us()["p99"] == 0.0
