"""Searches in a process of their own: answers, refusals, and a child that dies or hangs."""

import os
import signal
import time
from collections.abc import Iterator

import numpy as np
import pytest

from support.waiting import wait_until
from w2c.errors import GoalRefusedError, UnavailableError
from w2c.messages import Array, PlaceGoal, RobotDescription
from w2c_controller.preview.preview import preview
from w2c_controller.preview.search import StaticSearch
from w2c_controller.preview.search_process import SearchProcess


@pytest.fixture(scope="module")
def process(description: RobotDescription) -> Iterator[SearchProcess]:
    made = SearchProcess(timeout_s=1.0)
    made.begin(description)
    _wait_until_ready(made)
    yield made
    made.close()


def child_of(_search: StaticSearch) -> int:
    """Return who answers."""
    return os.getpid()


def refuse(_search: StaticSearch, *, reason: str) -> None:
    """Refuse."""
    raise GoalRefusedError(reason)


def fail(_search: StaticSearch) -> None:
    """Fail as no one foresaw."""
    raise ZeroDivisionError("by zero")


def take(_search: StaticSearch, seconds: float) -> None:
    """Take this long."""
    time.sleep(seconds)


def _answers(process: SearchProcess) -> bool:
    try:
        process.ask(child_of)
    except UnavailableError:
        return False
    return True


def _wait_until_ready(process: SearchProcess) -> None:
    wait_until(lambda: _answers(process), 60.0)


def test_another_process_answers(process: SearchProcess) -> None:
    assert process.ask(child_of) == process.pid != os.getpid()


def test_a_preview_is_the_same_as_here(
    process: SearchProcess, search: StaticSearch, joints: Array
) -> None:
    goal = PlaceGoal(
        goal_id="p",
        end_effector="left_hand",
        task="reach",
        point=np.array([1.3, 0.15, 0.9]),
        normal=np.array([0.0, 0.0, 1.0]),
    )
    search.start(joints)
    state = search.state.copy()
    here = preview(search, state, goal)
    there = process.ask(preview, state, goal)
    assert not there.reachable
    assert there.distance == pytest.approx(here.distance, abs=1e-9)
    assert there.reason == here.reason


def test_a_refusal_comes_back_as_what_it_is(process: SearchProcess) -> None:
    with pytest.raises(GoalRefusedError, match="because"):
        process.ask(refuse, reason="because")
    assert _answers(process)


def test_a_failure_of_a_search_does_not_end_the_process(process: SearchProcess) -> None:
    pid = process.pid
    with pytest.raises(UnavailableError, match="ZeroDivisionError: by zero"):
        process.ask(fail)
    assert process.pid == pid
    assert _answers(process)


def test_a_child_that_died_is_told_and_started_anew(process: SearchProcess) -> None:
    pid = process.pid
    os.kill(pid, signal.SIGKILL)
    with pytest.raises(UnavailableError, match="died"):
        process.ask(child_of)
    _wait_until_ready(process)
    assert process.pid != pid


def test_a_child_that_hangs_is_told_ended_and_started_anew(process: SearchProcess) -> None:
    pid = process.pid
    with pytest.raises(UnavailableError, match="within 1 s"):
        process.ask(take, 600.0)
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)
    _wait_until_ready(process)


def test_without_a_robot_there_is_no_search() -> None:
    with pytest.raises(UnavailableError, match="no process"):
        SearchProcess().ask(child_of)


def test_the_child_ends_with_its_owner(description: RobotDescription) -> None:
    made = SearchProcess()
    made.begin(description)
    pid = made.pid
    made.close()
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)
    made.close()
