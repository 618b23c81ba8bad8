"""A conversation that was recorded a moment ago is the same conversation when it is replayed."""

from pathlib import Path

import pytest
from msgspec.structs import replace

from support.rewriting import rewrapped, rewritten
from support.robot_played import Robot
from support.waiting import wait_until
from w2c import topics
from w2c.messages import CallTrace, CompleteReply, GoalEvent, Message
from w2c_dialogue.config import DialogueConfig
from w2c_dialogue.node import DialogueNode
from w2c_recorder.mcap_file import McapFile
from w2c_recorder.reading import Recorded, decode_call
from w2c_recorder.report import Report
from w2c_recorder.through.commands import compare
from w2c_recorder.through.options import ThroughOptions

TURN = "event/dialogue/turn"


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Words, a yes, a motion that ends, and words for something that nobody can find."""
    robot = Robot()
    queue = robot.buses["console"].raw_queue("w2c/**")
    node = DialogueNode(DialogueConfig(robot="test"), robot.hub.connect("dialogue"), robot.clock)
    node.configure()
    turns = robot.buses["console"].queue(topics.TURN)
    robot.show(100)
    wait_until(lambda: robot.say("lean on the book").ok, 10.0)
    turn = robot.say("lean on the book")
    assert turn.target is not None
    goal_id = robot.confirm(turn.target.target_id).goal_id
    robot.show(200)
    event = GoalEvent(
        stamp_ns=5, goal_id=goal_id, end_effector="right_hand", task="contact", state="loaded"
    )
    robot.buses["controller"].publish(topics.GOAL_EVENT, event)
    while (told := turns.receive(10.0)) is not None and told.message.goal_id != goal_id:
        pass
    told = turns.receive(10.0)
    assert told is not None
    assert told.message.text == ""
    robot.buses["llm"].close()
    assert not robot.say("lean on the book").ok
    node.close()
    path = tmp_path_factory.mktemp("dialogue") / "session.mcap"
    file = McapFile(path, {})
    while (received := queue.receive(0.0)) is not None:
        file.write(received, received.received_ns)
    file.close()
    return path


def through(path: Path) -> Report:
    return compare(path, ThroughOptions(service="dialogue"))


def test_every_turn_is_taken_again(recording: Path) -> None:
    report = through(recording)
    assert report.status == 0, "\n".join(report.lines)
    count = report.values["outputs"][TURN]
    assert count["compared"] >= 5
    assert count["equal"] == count["compared"]
    assert not count["skipped"]


def test_another_answer_of_a_model_is_another_turn(recording: Path, tmp_path: Path) -> None:
    def misunderstand(recorded: Recorded) -> Message | None:
        trace = recorded.message
        if not isinstance(trace, CallTrace):
            return trace
        _, reply = decode_call(trace)
        if not isinstance(reply, CompleteReply) or "objects" not in (reply.value or {}):
            return trace
        other = replace(reply, value={**reply.value, "objects": []})
        return replace(trace, reply=rewrapped(trace.reply, other))

    report = through(rewritten(recording, tmp_path / "other.mcap", misunderstand))
    assert report.status == 1
    first = report.values["first_difference"]
    assert first["output"] == TURN
    assert any(place.startswith("ok: True and False") for place in first["places"])


def test_a_question_that_was_not_asked_then_is_shown(recording: Path, tmp_path: Path) -> None:
    def forget(recorded: Recorded) -> Message | None:
        trace = recorded.message
        return None if isinstance(trace, CallTrace) and trace.method == "lift" else trace

    report = through(rewritten(recording, tmp_path / "forgotten.mcap", forget))
    assert report.status == 1
    text = "\n".join(report.lines)
    assert "asked, and not in the recording: perception/lift: " in text, text
