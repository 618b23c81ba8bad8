"""The web application of the console on hands that are fake, with a client of it."""

import threading
from dataclasses import dataclass, field

from starlette.testclient import TestClient

from w2c.clock import StepClock
from w2c.errors import W2CError
from w2c.messages import (
    CameraFrame,
    ConfirmRequest,
    Message,
    PointRequest,
    SayRequest,
    StopReply,
    Turn,
)
from w2c_console.app import make_app
from w2c_console.journal import turn_entry
from w2c_console.model import ConsoleModel
from w2c_console.page import TurnEntry
from w2c_console.stop import StopOutcome

STAMP = 1_795_000_000_123_456_789
"""A stamp that a JavaScript number cannot hold"""


@dataclass
class FakeOperator:
    """Remembers what it was asked to do."""

    asked: list[Message] = field(default_factory=list)
    problem: W2CError | None = None
    acknowledges: bool = True
    answered: int = 0
    answering: threading.Event = field(default_factory=threading.Event)

    def __post_init__(self) -> None:
        self.answering.set()

    def say(self, request: SayRequest) -> TurnEntry:
        return self._answer(request)

    def confirm(self, request: ConfirmRequest) -> TurnEntry:
        return self._answer(request)

    def point(self, request: PointRequest) -> TurnEntry:
        return self._answer(request)

    def stop(self, reason: str) -> StopOutcome:
        return StopOutcome(acknowledged=self.acknowledges, mode="stopped", failures=[reason])

    def resume(self) -> StopReply:
        if self.problem is not None:
            raise self.problem
        return StopReply(mode="tracking", stamp_ns=STAMP)

    def _answer(self, request: Message) -> TurnEntry:
        self.asked.append(request)
        self.answering.wait(30.0)
        self.answered += 1
        if self.problem is not None:
            raise self.problem
        turn = Turn(stamp_ns=1, text="x", module="none", reply="done", ok=True, seconds=0.1)
        return turn_entry(turn, 0)


class Page:
    """A client of the application, with all that is behind it."""

    def __init__(self) -> None:
        self.model = ConsoleModel()
        self.operator = FakeOperator()
        app = make_app(
            self.model,
            self.operator,
            StepClock(),
            title="Title",
            robot="talos",
            allowed_hosts=frozenset({"localhost"}),
        )
        self.client = TestClient(app, base_url="http://localhost:8080")

    def picture(self, stamp_ns: int, jpeg: bytes = b"jpeg") -> None:
        frame = CameraFrame(
            stamp_ns=stamp_ns,
            frame="camera",
            width=64,
            height=48,
            intrinsics=(50.0, 50.0, 32.0, 24.0),
            jpeg=jpeg,
            depth=b"",
        )
        self.model.on_frame(frame, 0)
