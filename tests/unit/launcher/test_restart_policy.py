"""When a dead process is started again."""

from w2c_launcher.restart_policy import RestartPolicy


def test_the_delay_doubles_and_is_bounded() -> None:
    policy = RestartPolicy(first_delay_s=0.5, longest_delay_s=2.0, limit=10)
    assert [policy.died(t) for t in (0.0, 1.0, 2.0, 3.0)] == [0.5, 1.0, 2.0, 2.0]
    assert policy.restarts == 4


def test_too_many_deaths_within_the_window_end_it() -> None:
    policy = RestartPolicy(limit=2, window_s=60.0)
    assert policy.died(0.0) is not None
    assert policy.died(1.0) is not None
    assert policy.died(2.0) is None


def test_deaths_long_ago_are_forgiven() -> None:
    policy = RestartPolicy(first_delay_s=0.5, limit=1, window_s=10.0)
    assert policy.died(0.0) == 0.5
    assert policy.died(20.0) == 0.5
