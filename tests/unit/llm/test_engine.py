"""One thread owns the model; the queue is bounded; deadlines and cancellation hold."""

import threading
from collections.abc import Iterator

import pytest

from fakes.language_model import ScriptedBackend
from support.waiting import wait_until
from w2c.clock import StepClock
from w2c.errors import (
    ConfigError,
    DeadlineError,
    ModelError,
    RefusedError,
    UnavailableError,
    W2CError,
)
from w2c_llm.backend import Backend, Budget
from w2c_llm.engine import Engine

PATIENCE_S = 30.0


@pytest.fixture
def engine() -> Iterator[Engine]:
    engine = Engine(ScriptedBackend, capacity=2)
    engine.start()
    yield engine
    engine.close()


def in_thread(work: "threading.Thread") -> threading.Thread:
    work.start()
    return work


class Blocker:
    """Work that begins, says so, and goes on until it is released or its budget ends."""

    def __init__(self) -> None:
        self.begun, self.release = threading.Event(), threading.Event()

    def __call__(self, _: Backend, budget: Budget) -> str:
        self.begun.set()
        while not self.release.wait(0.005):
            budget.check()
        return "released"


def submit_in_background(
    engine: Engine, work: Blocker, outcomes: list[object], timeout_s: float = PATIENCE_S
) -> threading.Thread:
    def run() -> None:
        try:
            outcomes.append(engine.submit(work, timeout_s).value)
        except W2CError as error:
            outcomes.append(error)

    return in_thread(threading.Thread(target=run))


def test_the_backend_lives_on_one_thread_that_is_not_the_callers() -> None:
    made: list[ScriptedBackend] = []

    def make() -> Backend:
        made.append(ScriptedBackend(likelihoods=[-1.0, -2.0]))
        return made[0]

    engine = Engine(make)
    engine.start()
    callers = [
        in_thread(
            threading.Thread(
                target=lambda: engine.submit(lambda b, budget: b.score([], ["a"], 0, budget), 9.0)
            )
        )
        for _ in range(4)
    ]
    for caller in callers:
        caller.join()
    engine.close()
    assert made[0].closed
    assert len(made[0].chats) == 4
    assert len(made[0].threads) == 1
    assert threading.get_ident() not in made[0].threads


def test_a_backend_that_allows_it_is_used_by_several_threads() -> None:
    engine = Engine(lambda: ScriptedBackend(concurrent_calls=2))
    engine.start()
    meeting = threading.Barrier(3)
    outcomes: list[int] = []
    callers = [
        in_thread(
            threading.Thread(
                target=lambda: outcomes.append(
                    engine.submit(lambda _b, _t: meeting.wait(PATIENCE_S), PATIENCE_S).value
                )
            )
        )
        for _ in range(2)
    ]
    meeting.wait(PATIENCE_S)  # passes only when both are served at once
    for caller in callers:
        caller.join()
    engine.close()
    assert len(outcomes) == 2


def test_a_full_queue_refuses_at_once_and_says_how_many_wait(engine: Engine) -> None:
    blocker, outcomes = Blocker(), list[object]()
    threads = [submit_in_background(engine, blocker, outcomes)]
    assert blocker.begun.wait(PATIENCE_S)
    threads += [submit_in_background(engine, blocker, outcomes) for _ in range(2)]
    wait_until(lambda: engine.queue_length == 2)
    with pytest.raises(UnavailableError, match="2 requests wait"):
        engine.submit(blocker, PATIENCE_S)
    blocker.release.set()
    for thread in threads:
        thread.join()
    assert outcomes == ["released"] * 3
    assert engine.queue_length == 0


def test_work_that_takes_too_long_ends_with_a_deadline_error(engine: Engine) -> None:
    with pytest.raises(DeadlineError):
        engine.submit(Blocker(), 0.02)
    assert engine.submit(lambda _b, _t: "next", PATIENCE_S).value == "next"


def test_work_whose_deadline_passed_in_the_queue_is_never_run() -> None:
    clock = StepClock()
    engine = Engine(ScriptedBackend, clock=clock)
    engine.start()
    blocker, late = Blocker(), Blocker()
    released, refused = list[object](), list[object]()
    first = submit_in_background(engine, blocker, released, 1000.0)
    assert blocker.begun.wait(PATIENCE_S)
    second = submit_in_background(engine, late, refused, 10.0)
    wait_until(lambda: engine.queue_length == 1)
    clock.set(20_000_000_000)
    blocker.release.set()
    first.join()
    second.join()
    engine.close()
    assert released == ["released"]
    assert [type(outcome) for outcome in refused] == [DeadlineError]
    assert not late.begun.is_set()


def test_an_error_reaches_its_caller_and_the_thread_lives_on(engine: Engine) -> None:
    def refuse(_: Backend, __: Budget) -> None:
        raise RefusedError("no")

    def break_down(_: Backend, __: Budget) -> None:
        raise ZeroDivisionError("oops")

    with pytest.raises(RefusedError, match="no"):
        engine.submit(refuse, PATIENCE_S)
    with pytest.raises(ModelError, match="ZeroDivisionError: oops"):
        engine.submit(break_down, PATIENCE_S)
    assert engine.submit(lambda _b, _t: 1, PATIENCE_S).value == 1


def test_closing_ends_what_runs_and_what_waits(engine: Engine) -> None:
    blocker, outcomes = Blocker(), list[object]()
    threads = [submit_in_background(engine, blocker, outcomes)]
    assert blocker.begun.wait(PATIENCE_S)
    threads.append(submit_in_background(engine, blocker, outcomes))
    wait_until(lambda: engine.queue_length == 1)
    engine.close()
    for thread in threads:
        thread.join()
    assert [type(outcome) for outcome in outcomes] == [UnavailableError, UnavailableError]
    with pytest.raises(UnavailableError):
        engine.submit(blocker, 1.0)


def test_a_model_that_does_not_load_is_an_error_of_start() -> None:
    def fail() -> Backend:
        raise ConfigError("no such file")

    engine = Engine(fail)
    with pytest.raises(ConfigError, match="no such file"):
        engine.start()
    engine.close()
