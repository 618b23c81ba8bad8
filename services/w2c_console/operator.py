"""What the operator can do, as calls on the bus."""

import logging
import time
from collections.abc import Sequence
from typing import Protocol

from w2c import topics
from w2c.bus import Bus
from w2c.errors import RefusedError, UnavailableError
from w2c.messages import (
    ConfirmRequest,
    Empty,
    PointRequest,
    SayRequest,
    StopReply,
    Turn,
)
from w2c_console.journal import turn_entry
from w2c_console.page import TurnEntry
from w2c_console.stop import StopLine, StopOutcome, deliver_stop

log = logging.getLogger("w2c.console")


class Operator(Protocol):
    """The operator's hands. Every method blocks until there is an answer; they raise W2CError."""

    def say(self, request: SayRequest) -> TurnEntry:
        """Say something about the picture on the screen."""

    def confirm(self, request: ConfirmRequest) -> TurnEntry:
        """Approve the target on the screen."""

    def point(self, request: PointRequest) -> TurnEntry:
        """Point at a pixel of the picture on the screen."""

    def stop(self, reason: str) -> StopOutcome:
        """Make the robot hold. Never raises."""

    def resume(self) -> StopReply:
        """Let the robot follow commands again."""


class BusOperator:
    """See `Operator`."""

    def __init__(self, bus: Bus, stop_lines: Sequence[StopLine]) -> None:
        self._bus = bus
        self._stop_lines = stop_lines

    def say(self, request: SayRequest) -> TurnEntry:
        """Say something about the picture on the screen."""
        return _entry(self._bus.call(topics.SAY, request).message)

    def confirm(self, request: ConfirmRequest) -> TurnEntry:
        """Approve the target on the screen."""
        return _entry(self._bus.call(topics.CONFIRM, request).message)

    def point(self, request: PointRequest) -> TurnEntry:
        """Point at a pixel of the picture on the screen."""
        return _entry(self._bus.call(topics.POINT, request).message)

    def stop(self, reason: str) -> StopOutcome:
        """Make the robot hold."""
        return deliver_stop(self._stop_lines, reason)

    def resume(self) -> StopReply:
        """Let the robot follow commands again, and the controller give them.

        Raises:
            W2CError: the robot does not answer, or the controller holds again at once, and why.
        """
        reply = self._bus.call(topics.ROBOT_RESUME, Empty()).message
        try:
            controller = self._bus.call(topics.CONTROLLER_RESUME, Empty()).message
        except UnavailableError:
            # A controller that is not there holds nothing; the page shows that it is absent.
            log.info("resumed without a controller")
            return reply
        if controller.holding:
            raise RefusedError(f"the controller still holds: {controller.text}")
        return reply


def _entry(turn: Turn) -> TurnEntry:
    return turn_entry(turn, time.time_ns() // 1_000_000)
