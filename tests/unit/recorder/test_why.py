"""A command is followed back to the words, through references and ids."""

from pathlib import Path

import pytest

from support.recordings import raw_message, write_recording
from support.sessions import Session, conversation, move, state, status
from w2c import messages as m
from w2c import topics
from w2c.errors import RecordingError
from w2c_recorder.history import history_of
from w2c_recorder.liveliness import Liveliness, key_of
from w2c_recorder.reading import Recording
from w2c_recorder.why import Step, explain, motion_at


def chain(path: Path, at: float) -> list[Step]:
    recording = Recording(path)
    history = history_of(recording)
    return list(explain(history, motion_at(recording, history.instant(at))))


def test_the_chain_leads_from_the_command_to_the_first_words(session_file: Path) -> None:
    steps = chain(session_file, 3.345)

    assert [step.what for step in steps] == [
        "command", "state", "phase", "goal", "request", "confirmation",
        "target", "words", "frame",
        "target", "words", "heatmap", "call", "frame",
    ]  # fmt: skip
    text = {index: step.text for index, step in enumerate(steps)}
    assert text[0] == "joint command of tick 4"
    assert text[1].startswith("of tick 4, robot tracking")
    assert text[2] == "approach towards goal-3"
    assert "right_hand contact, accepted" in text[3]
    assert "console confirmed target-2" in text[5]
    assert text[6].startswith("target-2 at (20.0, 24.0)")
    assert 'console said "to the left"' in text[7]
    assert "box of 'book' [30 14 50 34]" in text[9]
    assert 'console said "on the book"' in text[10]
    assert text[11] == "seg: 'book' at (40, 24), score 0.90, 40 ms"


def test_each_link_says_how_it_was_found(session_file: Path) -> None:
    links = {step.what: step.link for step in chain(session_file, 3.345)}

    assert (links["state"], links["request"], links["frame"]) == ("inputs", "goal_id", "inputs")


def test_a_robot_without_a_goal_stands(tmp_path: Path) -> None:
    session = Session()
    session.add(0.0, topics.CONTROLLER_STATUS, status("hold"))
    source = session.add(0.1, topics.ROBOT_STATE, state(1))
    command = m.JointCommand(tick=1, position=state(1).position)
    session.add(0.11, topics.JOINT_COMMAND, command, [source])

    steps = chain(session.write(tmp_path / "a.mcap"), 0.11)

    assert steps[-1].text == "none was set before: the robot stands"


def test_a_goal_without_a_conversation_says_who_set_it(tmp_path: Path) -> None:
    session = Session()
    move(session)

    steps = chain(session.write(tmp_path / "a.mcap"), 0.25)

    assert steps[-1].what == "confirmation"
    assert "set the goal without a conversation" in steps[-1].text


def test_missing_parts_are_named(tmp_path: Path) -> None:
    session = conversation()
    lost = (topics.CAMERA_FRAME.key("test"), topics.ROBOT_STATE.key("test"))
    session.raw = [raw for raw in session.raw if raw.key not in lost]

    texts = [step.text for step in chain(session.write(tmp_path / "a.mcap"), 3.345)]

    assert "of tick 4: not in the recording" in texts
    assert "picture of robot time 5.000 s: not in the recording" in texts


def test_a_time_before_the_first_command_or_after_the_end_is_an_error(session_file: Path) -> None:
    with pytest.raises(RecordingError, match=r"no joint command was recorded before 1\.000 s"):
        chain(session_file, 1.0)
    with pytest.raises(RecordingError, match=r"9\.000 s is outside of the recording"):
        chain(session_file, 9.0)


def test_a_process_that_came_meanwhile_hides_no_command(tmp_path: Path) -> None:
    """Who comes is written at once; what had arrived before may wait in the queue."""
    session = Session()
    session.add(0.0, topics.CONTROLLER_STATUS, status("hold"))
    for tick in (1, 2):
        command = m.JointCommand(tick=tick, position=state(1).position)
        session.add(0.1 * tick, topics.JOINT_COMMAND, command)
    session.add(0.4, topics.MARK, m.MarkRequest(text="the end"))
    came = Liveliness(service="llm", instance="0", alive=True)
    session.raw.insert(
        2, raw_message(came, key_of("test", came), received_ns=session.raw[-1].received_ns)
    )
    write_recording(tmp_path / "a.mcap", session.raw)

    assert chain(tmp_path / "a.mcap", 0.25)[0].text == "joint command of tick 2"
