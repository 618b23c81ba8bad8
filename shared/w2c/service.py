"""The life cycle every process shares: configure, ready, run, drain, stop.

A service gives a node: an object with `configure()`, `run(stop)` and `close()`. This module gives
it a bus, a
clock, a log, health reports, and an orderly end at SIGTERM and SIGINT.
"""

import logging
import math
import os
import signal
import threading
import time
from collections.abc import Callable
from typing import Protocol, TypeVar, runtime_checkable

import psutil

from w2c import topics
from w2c.bus import Bus
from w2c.clock import Clock, RealClock
from w2c.config import ServiceConfig, fail, parse
from w2c.errors import W2CError
from w2c.extras import needs_extra
from w2c.facts import Facts
from w2c.logs import configure_logs, logs_on
from w2c.messages import Health

C = TypeVar("C", bound=ServiceConfig)

HEALTH_PERIOD_S = 1.0
SIGNAL_PERIOD_S = 0.2
"""How long a signal may stay unseen by who waits for it"""


class Node(Protocol):
    """One process's bus in, bus out."""

    def configure(self) -> None:
        """Load models, subscribe, serve. The process is ready when this returns."""

    def run(self, stop: threading.Event) -> None:
        """Work until `stop` is set, then return within a second."""

    def close(self) -> None:
        """Release what `configure` took. Called in every case, after an error too."""


@runtime_checkable
class QueueingNode(Protocol):
    """A node whose requests wait in a queue of its own; the health reports show its length."""

    @property
    def queue_length(self) -> int:
        """Number of requests that wait."""


@runtime_checkable
class DetailedNode(Protocol):
    """A node that has something to say of itself; the health reports show it."""

    @property
    def detail(self) -> str:
        """What people should know; "" = nothing."""


class HealthReporter:
    """Publishes the state of the process once a second, from a thread of its own."""

    def __init__(self, bus: Bus, facts: Callable[[], dict[str, str]] = dict) -> None:
        self._bus = bus
        self._facts = facts
        self._process = psutil.Process()
        self._stop = threading.Event()
        self._phase = "configure"
        self._detail = ""
        self.queue_length: Callable[[], int] = lambda: 0
        self.node_detail: Callable[[], str] = lambda: ""
        self._process.cpu_percent()
        self._thread = threading.Thread(target=self._run, name="health", daemon=True)
        self._thread.start()

    def set_phase(self, phase: str, detail: str = "") -> None:
        """Report a change at once: the launcher waits for it."""
        self._phase, self._detail = phase, detail
        self.report()

    def report(self) -> None:
        """Publish one report."""
        health = Health(
            stamp_ns=time.time_ns(),
            service=self._bus.service,
            instance=self._bus.instance,
            phase=self._phase,
            detail=self._detail or self.node_detail(),
            pid=os.getpid(),
            cpu_percent=self._process.cpu_percent(),
            memory_mb=self._process.memory_info().rss / 1e6,
            queue_length=self.queue_length(),
            counters=dict(self._bus.counters),
            facts=self._facts(),
        )
        self._bus.publish(topics.HEALTH, health)

    def stop(self) -> None:
        """End the thread."""
        self._stop.set()
        self._thread.join(timeout=2.0)

    def _run(self) -> None:
        while not self._stop.wait(HEALTH_PERIOD_S):
            self.report()


class SignalledEvent(threading.Event):
    """An event for signal handlers to set. Its waiter looks for signals by itself.

    The kernel may give a signal to any thread, one of Zenoh's for example. Python runs the handler
    in the main thread, and nothing wakes that one from a lock it waits for: one SIGTERM in eight to
    a router whose clients ended in the same moment was never heeded.
    """

    def wait(self, timeout: float | None = None) -> bool:
        """Wait up to `timeout` [s]; None: for ever. Tells whether the event is set."""
        deadline = math.inf if timeout is None else time.monotonic() + timeout
        while not super().wait(min(SIGNAL_PERIOD_S, max(deadline - time.monotonic(), 0.0))):
            if time.monotonic() >= deadline:
                return False
        return True


def stop_on_signals() -> threading.Event:
    """Return an event that SIGTERM and SIGINT set."""
    stop = SignalledEvent()
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: stop.set())
    return stop


def run_node(
    make_node: Callable[[Bus, Clock], Node],
    bus: Bus,
    clock: Clock,
    stop: threading.Event,
    facts: Callable[[], dict[str, str]] = dict,
) -> None:
    """Take a node through its life. Errors of the node come out after it was closed."""
    log = logging.getLogger("w2c.service")
    health = HealthReporter(bus, facts)
    health.set_phase("configure")
    node = make_node(bus, clock)
    if isinstance(node, QueueingNode):
        health.queue_length = lambda: node.queue_length
    if isinstance(node, DetailedNode):
        health.node_detail = lambda: node.detail
    try:
        node.configure()
        health.set_phase("ready")
        log.info("ready")
        node.run(stop)
        health.set_phase("drain")
    except Exception as error:
        health.set_phase("failed", str(error))
        raise
    finally:
        node.close()
        health.stop()


def main(
    service: str,
    config_type: type[C],
    load_node: Callable[[], Callable[[C, Bus, Clock], Node]],
    arguments: list[str] | None,
    *,
    extra: str,
    on_robot_host: bool = False,
    hub: bool = False,
    verb: str = "",
) -> int:
    """Run one service from its flags. Returns the exit status: 0 done, 1 failed, 2 usage.

    `load_node` imports the node module, and with it the heavy dependencies of the extra.
    `on_robot_host` connects to the robot's own endpoint, not to the router; `hub` is the robot
    itself,
    which listens there. `verb` is the word after `w2c`, where it is not the service's own.
    """
    import sys

    program = f"w2c {verb or service}"
    argv = sys.argv[1:] if arguments is None else arguments
    try:
        config = parse(config_type, argv, program=program, table=verb or service)
        with needs_extra(extra):
            node_factory = load_node()
        stop = stop_on_signals()
        from w2c.bus.zenoh_bus import connect, connect_hub

        configure_logs(service, config.log_level, config.run_directory)
        endpoint = config.robot_endpoint if on_robot_host else config.router
        opened = connect_hub(config, service) if hub else connect(config, service, [endpoint])
        with opened as bus, logs_on(bus):
            run_node(lambda b, c: node_factory(config, b, c), bus, RealClock(), stop, Facts(config))
    except W2CError as error:
        logging.getLogger("w2c.service").error("%s", error)
        return fail(error, program)
    return 0
