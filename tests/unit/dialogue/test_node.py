"""The dialogue as a service: requests in, targets and turns out, other services over the bus."""

import threading
from collections.abc import Callable, Iterator

import pytest

from support.robot_played import Robot, frame_of
from w2c import topics
from w2c.bus.interface import CallContext
from w2c.errors import UnavailableError
from w2c.messages import (
    GoalEvent,
    HeightField,
    HeightFieldRequest,
    LiftReply,
    LiftRequest,
    PointRequest,
    StopRequest,
)
from w2c_dialogue.config import DialogueConfig
from w2c_dialogue.interfaces import Frame
from w2c_dialogue.node import DialogueNode

WAIT_S = 10.0


@pytest.fixture
def robot() -> Robot:
    return Robot()


@pytest.fixture
def node(robot: Robot) -> Iterator[DialogueNode]:
    bus = robot.hub.connect("dialogue")
    dialogue = DialogueNode(DialogueConfig(robot="test"), bus, robot.clock)
    dialogue.configure()
    yield dialogue
    dialogue.close()
    bus.close()


def until(condition: Callable[[], bool]) -> None:
    """Wait until a condition holds, or fail."""
    done = threading.Event()
    for _ in range(int(WAIT_S / 0.01)):
        if condition():
            return
        done.wait(0.01)
    pytest.fail("the condition did not come true")


@pytest.mark.usefixtures("node")
def test_say_and_confirm_over_the_bus(robot: Robot) -> None:
    console = robot.buses["console"]
    targets, turns = console.queue(topics.TARGET), console.queue(topics.TURN)
    robot.show(100)
    until(lambda: robot.say("lean on the book").ok)
    while (
        received := targets.receive(WAIT_S)
    ) is not None and received.message.state != "proposed":
        pass
    assert received is not None
    proposed = received.message
    assert (proposed.u, proposed.v, proposed.frame_stamp_ns) == (500, 360, 100)

    turn = robot.confirm(proposed.target_id)
    assert turn.ok
    assert robot.controller.goals[0].goal_id == turn.goal_id
    confirmed = targets.receive(WAIT_S)
    assert confirmed is not None
    assert confirmed.message.state == "confirmed"

    robot.buses["controller"].publish(
        topics.GOAL_EVENT,
        GoalEvent(
            stamp_ns=5,
            goal_id=turn.goal_id,
            end_effector="right_hand",
            task="contact",
            state="loaded",
        ),
    )
    landed = targets.receive(WAIT_S)
    assert landed is not None
    assert landed.message.state == "in_contact"
    modules: list[str] = []
    while len(modules) < 3 or modules[-1] != "none":
        received_turn = turns.receive(WAIT_S)
        assert received_turn is not None
        modules.append(received_turn.message.module)
    assert modules[-3:] == ["prediction.absolute", "confirmation", "none"]


@pytest.mark.usefixtures("node")
def test_a_target_that_waits_for_a_yes_stays_on_the_screen_when_a_motion_ends(robot: Robot) -> None:
    robot.show(100)
    until(lambda: robot.say("lean on the book").ok)
    turn = robot.say("lean on the book")
    assert turn.target is not None
    goal_id = robot.confirm(turn.target.target_id).goal_id
    waiting = robot.say("lean on the book").target
    assert waiting is not None
    targets = robot.buses["console"].queue(topics.TARGET)
    robot.buses["controller"].publish(
        topics.GOAL_EVENT,
        GoalEvent(
            stamp_ns=5, goal_id=goal_id, end_effector="right_hand", task="contact", state="loaded"
        ),
    )
    told = [targets.receive(WAIT_S), targets.receive(WAIT_S)]
    assert [(t.message.target_id, t.message.state) for t in told if t is not None] == [
        (turn.target.target_id, "in_contact"),
        (waiting.target_id, "proposed"),
    ]


@pytest.mark.usefixtures("node")
def test_a_turn_names_the_models_that_answered(robot: Robot) -> None:
    robot.show(100)
    until(lambda: robot.say("lean on the book").ok)
    evidence = robot.say("lean on the book").evidence
    assert evidence is not None
    assert {answer.model for answer in evidence.answers} == {"fake"}
    assert evidence.vision_model == "fake"


@pytest.mark.usefixtures("node")
def test_stop_reaches_the_driver_though_the_controller_serves_no_stop(robot: Robot) -> None:
    turn = robot.say("stop!")
    assert turn.ok
    assert robot.controller.stops
    assert "did not acknowledge" in turn.reply


@pytest.mark.usefixtures("node")
def test_missing_services_are_named(robot: Robot) -> None:
    robot.show(100)
    robot.buses["llm"].close()
    turn = robot.say("lean on the book")
    assert not turn.ok
    assert "language model cannot be asked now" in turn.reply


def test_a_goal_the_controller_forgot_is_given_up(robot: Robot, node: DialogueNode) -> None:
    robot.show(100)
    until(lambda: robot.say("lean on the book").ok)
    turn = robot.say("lean on the book")
    assert turn.target is not None
    goal_id = robot.confirm(turn.target.target_id).goal_id
    turns = robot.buses["console"].queue(topics.TURN)
    robot.status(goal_id)
    robot.clock.set(robot.clock.now_ns() + 60_000_000_000)
    node.check_goal()
    assert "goes on to the old target" in robot.say("lean on the book").reply
    robot.status("", "restarted")
    node.check_goal()
    replies: list[str] = []
    while not any("restarted" in reply for reply in replies):
        received = turns.receive(WAIT_S)
        assert received is not None
        replies.append(received.message.reply)
    assert robot.say("lean on the book").ok


def test_the_target_is_repeated_for_late_readers(robot: Robot, node: DialogueNode) -> None:
    robot.show(100)
    until(lambda: robot.say("lean on the book").ok)
    late = robot.buses["console"].latest(topics.TARGET)
    stop = threading.Event()
    thread = threading.Thread(target=node.run, args=(stop,))
    thread.start()
    try:
        received = late.wait(WAIT_S)
    finally:
        stop.set()
        thread.join(WAIT_S)
    assert received is not None
    assert received.message.state == "proposed"


@pytest.mark.usefixtures("node")
def test_an_unserved_stop_is_not_called_done(robot: Robot) -> None:
    robot.buses["robot"].close()
    turn = robot.say("stop")
    assert not turn.ok
    assert "NOT ACKNOWLEDGED" in turn.reply
    with pytest.raises(UnavailableError):
        robot.buses["console"].call(topics.ROBOT_STOP, StopRequest())


@pytest.mark.usefixtures("node")
def test_a_turn_names_the_message_it_answers_and_grounding_the_picture_it_was_given(
    robot: Robot,
) -> None:
    console = robot.buses["console"]
    turns = console.queue(topics.TURN)
    robot.show(100)
    until(lambda: robot.say("lean on the book").ok)
    received = turns.receive(WAIT_S)
    while received is not None and not received.message.ok:
        received = turns.receive(WAIT_S)
    assert received is not None
    assert any("rpc/dialogue" in source.key for source in received.envelope.inputs)
    assert any("rgbd" in source.key for source in robot.ground_inputs)


def test_pixels_are_lifted_with_the_boot_of_the_robot_they_were_seen_on(
    robot: Robot, node: DialogueNode
) -> None:
    boots: list[str] = []
    robot.buses["perception"].close()
    perception = robot.hub.connect("perception")

    def lift(request: LiftRequest, _context: CallContext) -> LiftReply:
        boots.append(request.robot_boot_id)
        return robot.lift.lift(request.u, request.v, frame_of(request))

    def heights(request: HeightFieldRequest, _context: CallContext) -> HeightField:
        boots.append(request.robot_boot_id)
        return robot.lift.heights(frame_of(request))

    perception.serve(topics.LIFT, lift)
    perception.serve(topics.HEIGHT_FIELD, heights)
    robot.show(100, "first")
    until(lambda: robot.say("lean on the book").ok)
    turn = robot.say("lean on the book")
    assert turn.target is not None
    assert robot.confirm(turn.target.target_id).ok
    assert set(boots) == {"first"}
    assert len(boots) >= 3


def test_what_was_said_of_a_robot_before_it_started_anew_is_given_up(
    robot: Robot, node: DialogueNode
) -> None:
    robot.show(100, "first")
    until(lambda: robot.say("lean on the book").ok)
    turn = robot.say("lean on the book")
    assert turn.target is not None
    robot.show(100, "second")
    until(lambda: not node._frames.current(Frame(100, 1, 1, b"", robot_boot_id="first")))
    console = robot.buses["console"]

    refused = robot.confirm(turn.target.target_id)
    clicked = console.call(
        topics.POINT, PointRequest(u=1.0, v=1.0, frame_stamp_ns=100, robot_boot_id="first")
    ).message

    assert not refused.ok
    assert "started anew" in refused.reply
    assert not clicked.ok
    assert "started anew" in clicked.reply
    assert robot.controller.goals == []
    targets = console.queue(topics.TARGET)
    node.check_robot()
    received = targets.receive(WAIT_S)
    assert received is not None
    assert received.message.state == "abandoned"
    node.check_robot()
    assert targets.receive(0.05) is None, "it is given up once"


@pytest.mark.usefixtures("node")
def test_advice_follows_the_turn_on_a_stream_of_its_own(robot: Robot) -> None:
    """Words, click or correction: the answer never waits for it."""
    console = robot.buses["console"]
    told = console.queue(topics.ADVICE)
    robot.grounding.things["cloth"] = (400, 300, 600, 420)
    robot.show(100)
    until(lambda: robot.say("lean on the book").ok)
    received = told.receive(WAIT_S)
    while received is not None and received.message.pending:
        received = told.receive(WAIT_S)
    assert received is not None
    advice = received.message
    assert [remark.kind for remark in advice.remarks] == ["material", "surface", "reach"]
    assert robot.confirm(advice.target_id).ok


def test_the_health_says_which_words_of_the_veto_nobody_looks_for(
    robot: Robot, node: DialogueNode
) -> None:
    assert node.detail == ""
    robot.show(100)
    until(lambda: robot.say("lean on the book").ok)
    until(lambda: node.detail != "")
    assert "'person'" in node.detail
    assert "not looked for" in node.detail
