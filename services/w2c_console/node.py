"""The console's bus in, bus out."""

import logging
import threading
import time
from collections.abc import Callable, Sequence
from typing import TypeVar

from w2c import topics
from w2c.bus import Bus, Latest, Queue
from w2c.clock import Clock
from w2c.errors import ProcessError
from w2c.messages import Message
from w2c_console.app import make_app
from w2c_console.config import ConsoleConfig, check_exposure
from w2c_console.model import ConsoleModel
from w2c_console.operator import BusOperator
from w2c_console.server import WebServer, bind
from w2c_console.stop import BusLine, DialledLine, StopLine, dial_robot
from w2c_console.view import FRAMES_KEPT

M = TypeVar("M", bound=Message)

POLL_S = 0.2
"""How often the slow state is looked at: faster than a person reads [s]"""
RECEIVE_S = 0.25
"""How long a reader waits before it looks whether it should end [s]"""


class ConsoleNode:
    """Reads everything an operator should see, and serves the page."""

    def __init__(
        self,
        config: ConsoleConfig,
        bus: Bus,
        clock: Clock,
        stop_lines: Sequence[StopLine] | None = None,
    ) -> None:
        """Prepare.

        Args:
            config: where to serve.
            bus: connection of this process.
            clock: for the ages of what is shown.
            stop_lines: the ways to the robot in order; None = its own socket, then the router.
        """
        self._config = config
        self._bus = bus
        self._clock = clock
        self.model = ConsoleModel()
        """What is known at the moment"""
        self._robot_line = DialledLine(dial_robot(config))
        self._stop_lines = stop_lines or (self._robot_line, BusLine(bus))
        self._ending = threading.Event()
        self._threads: list[threading.Thread] = []
        self._server: WebServer | None = None
        self._url = ""

    @property
    def url(self) -> str:
        """Where the page is; known once configured."""
        return self._url

    def configure(self) -> None:
        """Take the port, subscribe. Raises ConfigError for a port in use or an exposed address."""
        config = self._config
        check_exposure(config)
        operator = BusOperator(self._bus, self._stop_lines)
        local = frozenset({"localhost", "127.0.0.1", "::1", config.host})
        app = make_app(
            self.model,
            operator,
            self._clock,
            title=config.title,
            robot=config.robot,
            allowed_hosts=None if config.allow_remote else local,
        )
        listener = bind(config.host, config.port)
        self._server = WebServer(app, listener)
        host = f"[{config.host}]" if ":" in config.host else config.host
        self._url = f"http://{host}:{listener.getsockname()[1]}/"
        self._subscribe()

    def run(self, stop: threading.Event) -> None:
        """Serve until `stop` is set."""
        if self._server is None:
            raise ProcessError("the console was not configured before it ran")
        self._server.start()
        logging.getLogger("w2c.console").info("page at %s", self._url, extra={"url": self._url})
        while not stop.wait(POLL_S):
            if not self._server.running:
                raise ProcessError(f"the web server at {self._url} ended by itself; see the log")
            self._poll()

    def close(self) -> None:
        """Free the port, end the readers."""
        self._ending.set()
        if self._server is not None:
            self._server.close()
        for thread in self._threads:
            thread.join(timeout=2.0)
        self._robot_line.close()

    def _subscribe(self) -> None:
        """Start a reader for each stream of which nothing may be missed; poll the others."""
        model, clock, bus = self.model, self._clock, self._bus
        # Pictures wait in a queue, not in a latest value, because a reader of that one polls.
        self._read(
            bus.queue(topics.CAMERA_FRAME, FRAMES_KEPT), lambda m: model.on_frame(m, clock.now_ns())
        )
        self._read(bus.queue(topics.CAMERA_VIEW), model.on_view)
        self._read(bus.queue(topics.TARGET), model.on_target)
        self._read(bus.queue(topics.ADVICE), model.on_advice)
        self._read(bus.queue(topics.ALLOWED_AREA), model.on_area)
        self._read(bus.queue(topics.TURN), lambda m: model.on_turn(m, _wall_ms()))
        self._read(bus.queue(topics.GOAL_EVENT), lambda m: model.on_goal(m, _wall_ms()))
        self._read(bus.queue(topics.HEALTH), lambda m: model.on_health(m, clock.now_ns()))
        polls = (
            _poll_of(bus.latest(topics.ROBOT_STATE), model.on_robot, clock),
            _poll_of(bus.latest(topics.CONTROLLER_STATUS), model.on_controller, clock),
            _poll_of(bus.latest(topics.RECORDER_STATUS), model.on_recorder, clock),
            _poll_of(bus.latest(topics.PROCESS_TABLE), model.on_table, clock),
        )
        self._polls: tuple[Callable[[], None], ...] = polls

    def _poll(self) -> None:
        for poll in self._polls:
            poll()
        self.model.on_alive(self._bus.alive())

    def _read(self, queue: Queue[M], handle: Callable[[M], None]) -> None:
        def read() -> None:
            while not self._ending.is_set():
                received = queue.receive(RECEIVE_S)
                if received is not None:
                    handle(received.message)

        thread = threading.Thread(target=read, name=f"read-{len(self._threads)}", daemon=True)
        self._threads.append(thread)
        thread.start()


def _poll_of(
    latest: Latest[M], handle: Callable[[M, int], None], clock: Clock
) -> Callable[[], None]:
    def poll() -> None:
        received = latest.take()
        if received is not None:
            handle(received.message, clock.now_ns())

    return poll


def _wall_ms() -> int:
    return time.time_ns() // 1_000_000
