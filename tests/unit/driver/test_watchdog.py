"""Every cell of the driver's table of modes, and every reason to refuse a command."""

import numpy as np
import pytest

from w2c.driver.watchdog import Refusal, Watchdog
from w2c.messages import Array

START = np.array([0.1, -0.2])
LIMITS = np.array([[-1.0, 0.5], [-3.0, 3.0]])  # (n, 2) [rad]
LARGEST_STEP = np.array([1.5, 6.0]) * 0.002 / 0.75


def make_watchdog() -> Watchdog:
    return Watchdog(START, LIMITS, period_s=0.002, timeout_ticks=25)


def mode_of(watchdog: Watchdog) -> str:
    return watchdog.mode


def tracking_watchdog(tick: int = 0) -> Watchdog:
    watchdog = make_watchdog()
    assert watchdog.offer(START, answered_tick=tick, now_tick=tick) is None
    return watchdog


def test_holds_the_initial_command_until_the_first() -> None:
    watchdog = make_watchdog()
    watchdog.check(10_000)
    assert mode_of(watchdog) == "holding"
    assert watchdog.command_tick == -1
    assert watchdog.command.tolist() == START.tolist()


def test_a_good_command_is_tracked() -> None:
    watchdog = make_watchdog()
    assert watchdog.offer(START + 0.001, answered_tick=0, now_tick=1) is None
    assert mode_of(watchdog) == "tracking"
    assert watchdog.command_tick == 0
    assert watchdog.command.tolist() == (START + 0.001).tolist()


def test_holds_after_the_time_out_not_before_and_tracks_again() -> None:
    watchdog = tracking_watchdog(tick=100)
    watchdog.check(125)
    assert mode_of(watchdog) == "tracking"
    watchdog.check(126)
    assert mode_of(watchdog) == "holding"
    assert watchdog.command.tolist() == START.tolist()
    assert watchdog.offer(START, answered_tick=130, now_tick=130) is None
    assert mode_of(watchdog) == "tracking"


@pytest.mark.parametrize(
    ("command", "answered", "refusal"),
    [
        (np.zeros(3), 101, "length"),
        (np.zeros((2, 1)), 101, "length"),
        (np.array([0.1, np.nan]), 101, "not_finite"),
        (np.array([0.1, np.inf]), 101, "not_finite"),
        (START + 1.01 * LARGEST_STEP, 101, "jump"),
        (START - np.array([0.0, 1.01 * LARGEST_STEP[1]]), 101, "jump"),
        (START, 100, "old"),
        (START, 99, "old"),
        (START, 102, "future"),
    ],
)
def test_bad_commands_change_nothing(command: Array, answered: int, refusal: Refusal) -> None:
    watchdog = tracking_watchdog(tick=100)
    assert watchdog.offer(command, answered_tick=answered, now_tick=101) == refusal
    assert mode_of(watchdog) == "tracking"
    assert watchdog.command.tolist() == START.tolist()
    assert watchdog.command_tick == 100


def test_the_largest_step_is_allowed_and_lost_commands_are_made_up_for() -> None:
    assert (
        tracking_watchdog(100).offer(START + 0.99 * LARGEST_STEP, answered_tick=101, now_tick=101)
        is None
    )
    assert (
        tracking_watchdog(100).offer(START + 2.9 * LARGEST_STEP, answered_tick=103, now_tick=103)
        is None
    )
    # However long the silence: who comes back begins near the command in force.
    assert (
        tracking_watchdog(100).offer(START + 5.1 * LARGEST_STEP, answered_tick=900, now_tick=900)
        == "jump"
    )


def test_a_burst_of_commands_that_waited_on_a_cut_link_is_refused() -> None:
    watchdog = tracking_watchdog(tick=100)
    watchdog.check(400)
    assert watchdog.offer(START, answered_tick=200, now_tick=400) == "old"
    assert mode_of(watchdog) == "holding"


def test_stop_holds_until_resumed_and_is_idempotent() -> None:
    watchdog = tracking_watchdog(tick=100)
    watchdog.stop()
    watchdog.stop()
    assert mode_of(watchdog) == "stopped"
    assert watchdog.offer(START, answered_tick=101, now_tick=101) == "stopped"
    watchdog.check(500)
    assert mode_of(watchdog) == "stopped"
    watchdog.resume()
    assert mode_of(watchdog) == "holding"
    assert watchdog.offer(START + 0.1, answered_tick=501, now_tick=501) == "jump"
    assert watchdog.offer(START, answered_tick=502, now_tick=502) is None
    assert mode_of(watchdog) == "tracking"


def test_resume_without_stop_does_nothing() -> None:
    watchdog = tracking_watchdog(tick=100)
    watchdog.resume()
    assert mode_of(watchdog) == "tracking"


def test_what_the_caller_does_with_his_array_later_does_not_matter() -> None:
    watchdog = make_watchdog()
    command = START.copy()
    watchdog.offer(command, answered_tick=0, now_tick=0)
    command[:] = 9.0
    assert watchdog.command.tolist() == START.tolist()
