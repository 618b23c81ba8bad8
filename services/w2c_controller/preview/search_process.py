"""A process of its own for searches: they take milliseconds of the interpreter, the loop has two.

The child builds the model once and answers one question at a time. It is started with the node; one
that died or hangs is ended and started anew, and whoever asked is told to ask again.
"""

import logging
import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any, Concatenate, ParamSpec, TypeVar

from w2c.errors import UnavailableError, W2CError
from w2c.messages import RobotDescription
from w2c_controller.kinematics.model import build_model
from w2c_controller.parameters import HANDS
from w2c_controller.preview.search import StaticSearch

P = ParamSpec("P")
R = TypeVar("R")

TIMEOUT_S = 4.0
"""For an answer, wall time; most take some 20 ms."""
START_S = 60.0
"""A child that is not ready after this long hangs; two to ten seconds are usual [s]."""
READY = "ready"
NICENESS = 5
"""The loop comes first also where it has no real-time priority."""

log = logging.getLogger("w2c.controller")


class SearchProcess:
    """Asks questions about desired states. Thread-safe; the loop never calls it."""

    def __init__(self, timeout_s: float = TIMEOUT_S) -> None:
        """Begin without a child.

        Args:
            timeout_s: For an answer.
        """
        self._timeout_s = timeout_s
        self._asking = threading.Lock()
        self._description: RobotDescription | None = None
        self._child: _Child | None = None

    @property
    def pid(self) -> int:
        """Process id of the child; -1 without one."""
        return self._child.process.pid or -1 if self._child else -1

    @property
    def ready(self) -> bool:
        """Whether the child waits for questions."""
        with self._asking:
            try:
                return self._child is not None and self._child.is_ready(0.0)
            except (OSError, EOFError):
                return False

    def begin(self, description: RobotDescription) -> None:
        """Start a child for this robot, without waiting for it; ends the one there was."""
        with self._asking:
            self._end()
            self._description = description
            self._child = _Child(description)

    def ask(
        self, question: Callable[Concatenate[StaticSearch, P], R], *args: P.args, **kwargs: P.kwargs
    ) -> R:
        """Return what a function of a module answers, called in the child with its search.

        Raises:
            W2CError: what the function raised.
            UnavailableError: the child died or did not answer; it is started anew.
        """
        with self._asking:
            if self._child is None:
                raise UnavailableError("there is no process for searches; is the robot there?")
            try:
                self._wait_until_ready(self._child)
                self._child.pipe.send((question, args, kwargs))
                answer = self._receive(self._child)
            except (OSError, EOFError) as error:
                self._restart("died")
                raise UnavailableError(
                    f"the process of the search died ({type(error).__name__}); it is started anew, "
                    "ask again in a few seconds"
                ) from error
        if isinstance(answer, Exception):
            raise answer
        result: R = answer
        return result

    def close(self) -> None:
        """End the child."""
        with self._asking:
            self._end()

    def _wait_until_ready(self, child: "_Child") -> None:
        if child.is_ready(self._timeout_s):
            return
        if time.monotonic() - child.started > START_S:
            self._restart("does not become ready")
            raise UnavailableError(
                f"the process of the search was not ready within {START_S:g} s; it is started anew"
            )
        raise UnavailableError("the search is still starting; ask again in a few seconds")

    def _receive(self, child: "_Child") -> Any:
        if child.pipe.poll(self._timeout_s):
            return child.pipe.recv()
        self._restart("hangs")
        raise UnavailableError(
            f"the search did not answer within {self._timeout_s:g} s; it is started anew, ask "
            "again in a few seconds"
        )

    def _restart(self, why: str) -> None:
        log.warning("the process of the search %s: starting it anew", why)
        self._end()
        if self._description is not None:
            self._child = _Child(self._description)

    def _end(self) -> None:
        if self._child is not None:
            self._child.end()
        self._child = None


class _Child:
    """One process with its pipe."""

    def __init__(self, description: RobotDescription) -> None:
        spawn = multiprocessing.get_context("spawn")
        self.pipe, theirs = spawn.Pipe()
        self._ready = False
        self.started = time.monotonic()
        self.process = spawn.Process(
            target=serve, args=(theirs, description), name="w2c-search", daemon=True
        )
        self.process.start()
        theirs.close()

    def is_ready(self, timeout_s: float) -> bool:
        """Return whether it has said that it waits for questions; gives it time to say so."""
        if not self._ready and self.pipe.poll(timeout_s):
            self._ready = self.pipe.recv() == READY
        return self._ready

    def end(self) -> None:
        """End it by force: it remembers nothing."""
        self.pipe.close()
        self.process.kill()
        self.process.join()
        self.process.close()


def serve(pipe: Connection, description: RobotDescription) -> None:
    """Answer questions until the pipe ends. Runs in the child."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides
    os.nice(NICENESS)
    model = build_model(description)
    search = StaticSearch(model)
    search.start(description.initial_position[model.joint_indices])
    for hand in HANDS:
        search.move(hand, search.position(hand))  # what is compiled is loaded before it is needed
    pipe.send(READY)
    while True:
        try:
            question, args, kwargs = pipe.recv()
        except (EOFError, OSError):
            return
        pipe.send(_answer(search, question, args, kwargs))


def _answer(
    search: StaticSearch, question: Callable[..., Any], args: tuple[Any, ...], kwargs: Any
) -> Any:
    """Return the answer, or the error in its place."""
    try:
        return question(search, *args, **kwargs)
    except W2CError as error:
        return error
    except Exception as error:
        log.exception("a search failed")
        return UnavailableError(f"the search failed: {type(error).__name__}: {error}")
