"""Stop: two ways, whichever answers first, and the truth about the outcome."""

import threading
from dataclasses import dataclass, field

import pytest

from w2c import topics
from w2c.bus import InProcessHub
from w2c.errors import ConnectionFailedError, UnavailableError
from w2c.messages import StopReply, StopRequest
from w2c_console.stop import DialledLine, StopOutcome, deliver_stop


@dataclass
class FakeLine:
    """A way that answers, fails, or hangs until it is let go."""

    name: str
    mode: str = "stopped"
    fails: bool = False
    hangs: bool = False
    controller_fails: bool = False
    breaks: bool = False
    let_go_when_asked: threading.Event | None = None
    asked: list[StopRequest] = field(default_factory=list)
    let_go: threading.Event = field(default_factory=threading.Event)

    def stop_robot(self, request: StopRequest, timeout_s: float) -> StopReply:
        self.asked.append(request)
        if self.let_go_when_asked is not None:
            self.let_go_when_asked.set()
        if self.breaks:
            raise ZeroDivisionError("division by zero")
        if self.hangs:
            self.let_go.wait(30.0)
        if self.fails:
            raise UnavailableError("nobody answers")
        return StopReply(mode=self.mode, stamp_ns=42)

    def stop_controller(self, request: StopRequest, timeout_s: float) -> StopReply:
        if self.controller_fails:
            raise UnavailableError("controller is not running")
        return StopReply(mode="stopped", stamp_ns=42)


def stop(*lines: FakeLine, patience_s: float = 5.0, deadline_s: float = 5.0) -> StopOutcome:
    try:
        return deliver_stop(
            lines, "test", patience_s=patience_s, deadline_s=deadline_s, settle_s=5.0
        )
    finally:
        for line in lines:
            line.let_go.set()


def test_the_robots_own_socket_is_enough_and_the_router_is_not_asked() -> None:
    first, second = FakeLine("robot endpoint"), FakeLine("router")
    outcome = stop(first, second)
    assert outcome.acknowledged
    assert (outcome.mode, outcome.stamp, outcome.line) == ("stopped", "42", "robot endpoint")
    assert outcome.controller == "acknowledged"
    assert second.asked == []


def test_when_the_first_way_fails_the_second_is_tried_without_delay() -> None:
    outcome = stop(FakeLine("robot endpoint", fails=True), FakeLine("router"), patience_s=1e6)
    assert outcome.acknowledged
    assert outcome.line == "router"
    assert outcome.failures == ["robot endpoint: nobody answers"]


def test_when_the_first_way_is_silent_the_second_is_tried_as_well() -> None:
    first = FakeLine("robot endpoint", hangs=True)
    outcome = stop(first, FakeLine("router"), patience_s=0.01)
    assert outcome.acknowledged
    assert outcome.line == "router"
    assert len(first.asked) == 1


def test_a_late_answer_of_the_first_way_still_counts() -> None:
    first = FakeLine("robot endpoint", hangs=True)
    # The second way fails, and only then does the first one answer.
    second = FakeLine("router", fails=True, let_go_when_asked=first.let_go)
    outcome = stop(first, second, patience_s=0.01)
    assert outcome.acknowledged
    assert outcome.line == "robot endpoint"


def test_nothing_is_acknowledged_when_nobody_answers() -> None:
    outcome = stop(FakeLine("robot endpoint", fails=True), FakeLine("router", fails=True))
    assert not outcome.acknowledged
    assert outcome.failures == ["robot endpoint: nobody answers", "router: nobody answers"]


def test_silence_is_not_an_acknowledgement() -> None:
    outcome = stop(FakeLine("router", hangs=True), deadline_s=0.05)
    assert not outcome.acknowledged
    assert "no answer" in outcome.failures[0]


def test_a_robot_that_goes_on_tracking_did_not_stop() -> None:
    outcome = stop(FakeLine("router", mode="tracking"))
    assert not outcome.acknowledged
    assert "still tracking" in outcome.failures[0]


def test_the_controllers_word_alone_does_not_count() -> None:
    outcome = stop(FakeLine("router", fails=True))
    assert not outcome.acknowledged


def test_a_dead_controller_does_not_hide_the_robots_acknowledgement() -> None:
    outcome = deliver_stop([FakeLine("router", controller_fails=True)], "test", settle_s=0.05)
    assert outcome.acknowledged
    assert outcome.controller == "controller is not running"


def test_any_failure_becomes_a_verdict() -> None:
    """Whatever the transport raises, the operator reads it; nothing escapes into the server."""
    outcome = stop(FakeLine("router", breaks=True))
    assert not outcome.acknowledged
    assert "division by zero" in outcome.failures[0]


def test_the_robots_socket_is_dialled_once_and_again_after_a_failure() -> None:
    hub = InProcessHub()
    dialled = []

    def dial() -> object:
        dialled.append(1)
        return hub.connect("operator")

    line = DialledLine(dial)  # type: ignore[arg-type]
    robot = hub.connect("robot")
    robot.serve(topics.ROBOT_STOP, lambda _, __: StopReply(mode="stopped", stamp_ns=1))
    for _ in range(2):
        assert line.stop_robot(StopRequest(), 1.0).mode == "stopped"
    assert len(dialled) == 1
    robot.close()
    with pytest.raises(UnavailableError):
        line.stop_robot(StopRequest(), 1.0)
    hub.connect("robot").serve(
        topics.ROBOT_STOP, lambda _, __: StopReply(mode="stopped", stamp_ns=1)
    )
    assert line.stop_robot(StopRequest(), 1.0).mode == "stopped"
    assert len(dialled) == 2
    line.close()


def test_a_socket_that_cannot_be_dialled_is_told() -> None:
    def dial() -> object:
        raise ConnectionFailedError("no answer at tcp/127.0.0.1:7448")

    outcome = deliver_stop([DialledLine(dial)], "test")  # type: ignore[arg-type]
    assert not outcome.acknowledged
    assert "7448" in outcome.failures[0]
