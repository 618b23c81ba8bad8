"""What a loop asks of the system, and that it is told what it did not get."""

import gc
import os
from collections.abc import Callable

import pytest

from w2c import realtime


def test_what_is_granted_is_in_force_and_is_given_back() -> None:
    with realtime.real_time(10) as granted:
        policy = os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK
        assert granted.priority == (policy == os.SCHED_FIFO)
        assert (granted.trouble == "") == (granted.priority and granted.memory_locked)
    assert os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK == os.SCHED_OTHER


def test_what_is_refused_is_said_with_what_would_grant_it(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    monkeypatch.setattr(realtime, "_lock_memory", lambda: "Cannot allocate memory")
    with realtime.real_time(10) as granted:
        assert not granted.priority
        assert not granted.memory_locked
        assert "CAP_SYS_NICE" in granted.trouble
        assert "CAP_IPC_LOCK" in granted.trouble


@pytest.mark.parametrize(("cores", "asked"), [(2, 0), (4, 1)])
def test_auto_leaves_a_small_machine_to_the_models(
    cores: int, asked: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls: list[int] = []

    def grant(priority: int) -> str:
        calls.append(priority)
        return ""

    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(cores)))
    monkeypatch.setattr(realtime, "_raise_priority", grant)
    with realtime.real_time(10, "auto") as granted:
        assert len(calls) == asked
        assert granted.priority == bool(asked)
        assert ("2 cores" in granted.trouble) == (not asked)


def test_off_asks_for_nothing() -> None:
    with realtime.real_time(10, "off") as granted:
        assert granted == realtime.NOT_ASKED


def garbage() -> None:
    for _ in range(5000):
        cycle: list[object] = []
        cycle.append(cycle)


@pytest.mark.parametrize("make", [garbage])
def test_the_collector_does_not_run_and_that_is_seen(make: Callable[[], None]) -> None:
    with realtime.collector_off() as watch:
        make()
        assert watch.runs == 0
        gc.collect()
        assert watch.runs == 1
    assert gc.isenabled()
    assert gc.get_freeze_count() == 0
