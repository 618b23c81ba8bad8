"""Who joins a replay finds the robot described, and things as they stood."""

import threading
from pathlib import Path
from typing import Any

import msgspec
import pytest

from support.examples import all_examples
from support.recordings import raw_mark, raw_message, write_recording
from support.robots import description
from support.sessions import conversation, frame, status, target, turn
from w2c import messages as m
from w2c import topics
from w2c.bus import InProcessHub, RawReceived, Received, decode_envelope
from w2c.clock import StepClock
from w2c.errors import UnavailableError
from w2c_recorder.liveliness import Liveliness, key_of
from w2c_recorder.reading import Recording
from w2c_recorder.replay.options import ReplayOptions
from w2c_recorder.replay.run import play
from w2c_recorder.report import Report

SECOND = 10**9
ASKED_KEY = topics.DESCRIBE.key("replay", "0")


class Newcomer:
    """A service on a replay that asks the robot what it is whenever that reports."""

    def __init__(self) -> None:
        self.hub = InProcessHub()
        self.replay = self.hub.connect("replay", robot="replay", instance="a")
        self.bus = self.hub.connect("perception", robot="replay")
        self.heard: list[RawReceived] = []
        self.told: list[tuple[str, bool]] = []
        """Camera of the description, and whether the start of the robot that reported gave it"""
        self.refused: list[str] = []
        self.hub.subscriptions.append((self, "w2c/v1/replay/**", self._hear))

    def play(self, path: Path, **options: Any) -> Report:
        """Play a file to the end and return the report."""
        chosen = msgspec.structs.replace(ReplayOptions(), **options)
        clock, stop = StepClock(SECOND), threading.Event()
        return play(Recording(path), chosen, self.replay, clock, stop, settle_s=0.0)

    def ask(self) -> Received[m.RobotDescription]:
        """Call robot/describe."""
        return self.bus.call(topics.DESCRIBE, m.Empty())

    def _hear(self, raw: RawReceived) -> None:
        self.heard.append(raw)
        if raw.key == topics.HEALTH.key("replay", "robot") and ASKED_KEY in self.hub.served:
            try:
                reply = self.ask()
            except UnavailableError as error:
                self.refused.append(str(error))
                return
            boot_id = decode_envelope(raw.payload).boot_id
            self.told.append((reply.message.camera_frame, reply.envelope.boot_id == boot_id))


def health(service: str, second: float, *, boot_id: str = "boot", sequence: int = 0) -> RawReceived:
    own = msgspec.structs.replace(all_examples()["Health"], service=service, instance="0")
    key = topics.HEALTH.key("test", service)
    at_ns = round(second * SECOND)
    return raw_message(own, key, sequence, boot_id=boot_id, sender=service, received_ns=at_ns)


def asked(name: str, boot_id: str, second: float, outcome: str = "ok") -> RawReceived:
    """Return the trace of a call of robot/describe."""
    own = msgspec.structs.replace(description(), camera_frame=name)
    reply = raw_message(own, "", boot_id=boot_id, sender="robot").payload
    trace = m.CallTrace(
        service="robot", method="describe", instance="0", outcome=outcome, duration_ms=1.0,
        request=b"", reply=reply if outcome == "ok" else b"",
    )  # fmt: skip
    key = topics.TRACE.key("test", "controller")
    return raw_message(trace, key, received_ns=round(second * SECOND))


@pytest.fixture
def restarted(tmp_path: Path) -> Path:
    """A robot that was started three times; after the last nobody asked what it is."""
    path = tmp_path / "session.mcap"
    write_recording(
        path,
        [health("robot", 1, boot_id="a"), asked("early", "a", 2, "deadline"),
         asked("first", "a", 3), health("robot", 4, boot_id="a", sequence=1),
         health("robot", 10, boot_id="b"), asked("second", "b", 11), raw_mark("x", 0, 13 * SECOND),
         health("robot", 20, boot_id="c")],
    )  # fmt: skip
    return path


def test_what_the_robot_is_is_answered_and_nothing_else(tmp_path: Path) -> None:
    session = conversation()
    own = msgspec.structs.replace(all_examples()["Health"], service="robot", instance="0")
    session.add(0.1, topics.HEALTH, own, sender="robot")
    session.call(1.7, topics.DESCRIBE, m.Empty(), description(), caller="controller")
    newcomer = Newcomer()

    report = newcomer.play(session.write(tmp_path / "session.mcap"), with_commands=True)

    assert newcomer.told == [(description().camera_frame, True)]
    assert newcomer.ask().message.urdf == description().urdf
    assert newcomer.ask().envelope.robot == "replay"
    assert list(newcomer.hub.served) == [ASKED_KEY]
    assert "calls answered as they were: robot/describe" in report.lines
    assert report.values["answered"] == ["robot/describe"]


def test_each_start_of_the_robot_has_its_own_answer(restarted: Path) -> None:
    newcomer = Newcomer()

    report = newcomer.play(restarted, exclude=("trace/*",))

    assert newcomer.told == [("first", True), ("first", True), ("second", True)]
    assert len(newcomer.refused) == 1
    assert "nobody asked it then" in newcomer.refused[0]
    assert any("robot/describe was not answered all the time" in line for line in report.lines)


def test_a_part_answers_as_the_robot_of_then(restarted: Path) -> None:
    newcomer = Newcomer()

    report = newcomer.play(restarted, start_s=11.5, end_s=14.0)

    assert newcomer.told == [("second", True)]
    assert not any("not answered" in line for line in report.lines)


def test_for_a_robot_that_is_not_shown_nobody_answers(restarted: Path) -> None:
    newcomer = Newcomer()

    report = newcomer.play(restarted, exclude=("health/robot/*",))

    assert not newcomer.hub.served
    assert "calls answered as they were: none" in report.lines


@pytest.mark.parametrize("close", [True, False], ids=["by its index", "without one"])
def test_a_part_begins_as_things_stood(tmp_path: Path, close: bool) -> None:
    def note(service: str, alive: bool, second: int) -> RawReceived:
        change = Liveliness(service=service, instance="0", alive=alive)
        return raw_message(change, key_of("test", change), received_ns=second * SECOND)

    def said(row: topics.Topic[Any], message: m.Message, second: int) -> RawReceived:
        return raw_message(message, row.key("test"), second, received_ns=second * SECOND)

    path = tmp_path / "session.mcap"
    event = m.GoalEvent(
        stamp_ns=0, goal_id="g", end_effector="right_hand", task="contact", state="accepted"
    )
    write_recording(
        path,
        [note("llm", True, 1), note("grounding", True, 1), health("llm", 2), health("grounding", 2),
         said(topics.CONTROLLER_STATUS, status("hold"), 2),
         said(topics.CONTROLLER_STATUS, status("approach", "g"), 3),
         said(topics.CAMERA_FRAME, frame(5 * SECOND), 3), said(topics.GOAL_EVENT, event, 3),
         said(topics.TURN, turn("there", "prediction.absolute", None), 3),
         said(topics.TURN, turn("", "confirmation", target(1, 5.0), state="moving"), 4),
         note("grounding", False, 5), raw_mark("end", 0, 30 * SECOND)],
        close=close,
    )  # fmt: skip
    newcomer = Newcomer()

    newcomer.play(path, start_s=20.0)

    heard = [
        (raw.key.split("/", 3)[-1], decode_envelope(raw.payload).data) for raw in newcomer.heard
    ]
    assert [name for name, _ in heard] == [
        "health/llm/status", "state/controller/status", "obs/camera/rgbd",
        "event/dialogue/turn", "event/recorder/mark",
    ]  # fmt: skip
    assert dict(heard)["state/controller/status"]["phase"] == "approach"
    assert dict(heard)["event/dialogue/turn"]["state"] == "moving"
