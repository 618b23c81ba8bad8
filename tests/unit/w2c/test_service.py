"""The life cycle of a process."""

import signal
import threading
from collections.abc import Iterator

import pytest

from w2c import topics
from w2c.bus import Bus, InProcessHub
from w2c.clock import Clock, RealClock
from w2c.errors import ModelError
from w2c.service import run_node, stop_on_signals


class Scripted:
    """A node that notes what was asked of it, and fails where told."""

    def __init__(self, fail_at: str = "") -> None:
        self.steps: list[str] = []
        self._fail_at = fail_at

    @property
    def queue_length(self) -> int:
        return 3

    def _step(self, name: str) -> None:
        self.steps.append(name)
        if name == self._fail_at:
            raise ModelError("no weights at /nowhere")

    def configure(self) -> None:
        self._step("configure")

    def run(self, stop: threading.Event) -> None:
        self._step("run")
        stop.wait(10.0)

    def close(self) -> None:
        self._step("close")


def life_of(node: Scripted) -> list[tuple[str, str, int]]:
    """Run a node on a stopped event; return its health reports as (phase, detail, queue)."""
    hub = InProcessHub()
    reports = hub.connect("launcher").queue(topics.HEALTH)

    def make(bus: Bus, clock: Clock) -> Scripted:
        return node

    stop = threading.Event()
    stop.set()
    try:
        run_node(make, hub.connect("llm"), RealClock(), stop)
    finally:
        found = []
        while (received := reports.receive(0.0)) is not None:
            health = received.message
            found.append((health.phase, health.detail, health.queue_length))
        node.steps.append(f"{len(found)} reports")
        REPORTS[:] = found
    return found


REPORTS: list[tuple[str, str, int]] = []


def test_a_node_goes_through_its_life_in_order_and_says_so() -> None:
    node = Scripted()
    phases = [phase for phase, _, _ in life_of(node)]
    assert node.steps[:3] == ["configure", "run", "close"]
    assert phases == ["configure", "ready", "drain"]


def test_the_length_of_the_queue_is_reported() -> None:
    assert {queue for _, _, queue in life_of(Scripted())[1:]} == {3}


@pytest.mark.parametrize("where", ["configure", "run"])
def test_a_node_that_fails_is_closed_and_its_words_are_reported(where: str) -> None:
    node = Scripted(fail_at=where)
    with pytest.raises(ModelError, match="no weights"):
        life_of(node)
    assert "close" in node.steps
    assert REPORTS[-1][:2] == ("failed", "no weights at /nowhere")


def test_what_the_process_is_is_in_each_report() -> None:
    hub, stop = InProcessHub(), threading.Event()
    reports = hub.connect("launcher").queue(topics.HEALTH)
    stop.set()
    facts = {"configuration": "{}"}

    run_node(lambda _bus, _clock: Scripted(), hub.connect("llm"), RealClock(), stop, lambda: facts)

    found = []
    while (received := reports.receive(0.0)) is not None:
        found.append(received.message.facts)
    assert found
    assert all(one == facts for one in found)


@pytest.fixture
def stop() -> Iterator[threading.Event]:
    """The event of a process; the handlers of the test run come back afterwards."""
    before = {number: signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGINT)}
    yield stop_on_signals()
    for number, handler in before.items():
        signal.signal(number, handler)


def test_a_signal_that_another_thread_got_ends_the_wait(stop: threading.Event) -> None:
    def get_it() -> None:
        signal.pthread_kill(threading.get_ident(), signal.SIGTERM)

    timer = threading.Timer(0.1, get_it)
    timer.start()
    assert stop.wait(10.0)
    timer.join()


def test_a_wait_without_a_signal_ends_in_time(stop: threading.Event) -> None:
    assert not stop.wait(0.0)
    assert not stop.wait(0.3)
