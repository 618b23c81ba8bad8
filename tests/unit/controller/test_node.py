"""The node on a bus, with a robot that answers as the driver does."""

import threading
from collections.abc import Iterator

import numpy as np
import pytest

from support.waiting import wait_until
from w2c import topics
from w2c.bus import InProcessHub
from w2c.clock import RealClock
from w2c.errors import ConnectionFailedError, RefusedError
from w2c.messages import (
    ControllerStatus,
    Empty,
    PlaceGoal,
    ReleaseGoal,
    StopRequest,
)
from w2c_controller.config import ControllerConfig
from w2c_controller.node import ControllerNode
from w2c_controller.search import StaticSearch
from w2c_sim_robot.config import RobotConfig
from w2c_sim_robot.description import make_description
from w2c_sim_robot.model import build_model
from w2c_sim_robot.node import RobotNode
from w2c_sim_robot.physics import Simulator

UP = np.array([0.0, 0.0, 1.0])


class Cell:
    """Robot, controller and operator on one in-process bus, in lock step."""

    def __init__(self) -> None:
        hub = InProcessHub()
        self.operator = hub.connect("operator")
        self.commands = self.operator.queue(topics.JOINT_COMMAND)
        self.events = self.operator.queue(topics.GOAL_EVENT)
        self.status = self.operator.latest(topics.CONTROLLER_STATUS)
        self.states = self.operator.latest(topics.ROBOT_STATE)
        self.robot = RobotNode(
            RobotConfig(robot="test", lock_step=True), hub.connect("robot"), RealClock()
        )
        self.robot.configure()
        self.controller_bus = hub.connect("controller")
        self.node = ControllerNode(ControllerConfig(robot="test"), self.controller_bus, RealClock())
        self.node.configure()
        wait_until(lambda: self.node.search.ready, 60.0)
        self._stop = threading.Event()
        self._threads = [
            threading.Thread(target=node.run, args=(self._stop,))
            for node in (self.node, self.robot)
        ]
        for thread in self._threads:
            thread.start()

    def close(self) -> None:
        self._stop.set()
        for thread in self._threads:
            thread.join(timeout=10.0)
        self.node.close()
        self.robot.close()

    def wait_status(self, phase: str) -> ControllerStatus:
        found: list[ControllerStatus] = []

        def look() -> bool:
            last = self.status.last()
            if last is not None and last.message.phase == phase:
                found.append(last.message)
            return bool(found)

        wait_until(look, 30.0)
        return found[0]


@pytest.fixture
def cell() -> Iterator[Cell]:
    made = Cell()
    yield made
    made.close()


def _reach(point: tuple[float, float, float]) -> PlaceGoal:
    return PlaceGoal(
        goal_id="g", end_effector="left_hand", task="reach", point=np.array(point), normal=UP
    )


def test_every_tick_is_answered_once_and_says_what_it_answers(cell: Cell) -> None:
    ticks = []
    for _ in range(50):
        received = cell.commands.receive(20.0)
        assert received is not None
        ticks.append(received.message.tick)
        assert received.envelope.inputs[0].key == topics.ROBOT_STATE.key("test")
    assert ticks == list(range(50))


def test_goals_previews_and_stop_over_the_bus(cell: Cell) -> None:
    cell.wait_status("hold")
    reply = cell.operator.call(topics.PLACE, _reach((0.6, 0.3, 1.0))).message
    assert reply.goal_id == "g"
    event = cell.events.receive(10.0)
    assert event is not None
    assert event.message.state == "accepted"
    with pytest.raises(RefusedError, match="behind"):
        cell.operator.call(topics.PLACE, _reach((-0.6, 0.3, 1.0)))
    preview = cell.operator.call(topics.PREVIEW, _reach((1.5, 0.3, 0.9))).message
    assert not preview.reachable
    assert preview.distance > 0.2
    assert cell.operator.call(topics.CONTROLLER_STOP, StopRequest(reason="test")).message.mode == (
        "stopped"
    )
    status = cell.wait_status("stopped")
    assert status.in_contact == (True, True, False, False)
    with pytest.raises(RefusedError, match="stopped"):
        cell.operator.call(topics.PLACE, _reach((0.6, 0.3, 1.0)))
    cell.operator.call(topics.ROBOT_RESUME, Empty())
    cell.wait_status("hold")


def test_a_contact_that_must_stay_is_refused_before_anything_moves(
    cell: Cell, monkeypatch: pytest.MonkeyPatch
) -> None:
    cell.wait_status("hold")
    lift = ReleaseGoal(goal_id="lift", end_effector="left_foot")
    with monkeypatch.context() as patched:
        search = StaticSearch(cell.node.controller.model)
        patched.setattr(search, "free", lambda _contact: False)
        patched.setattr(cell.node.search, "ask", lambda question, *args: question(search, *args))
        with pytest.raises(RefusedError, match="left foot cannot be taken off its support"):
            cell.operator.call(topics.RELEASE, lift)
    assert cell.events.receive(0.0) is None
    assert cell.operator.call(topics.RELEASE, lift).message.goal_id == "lift"
    status = cell.wait_status("unload")
    assert status.in_contact == (True, True, False, False)


def test_without_a_robot_the_controller_says_how_to_start_one() -> None:
    bus = InProcessHub().connect("controller")
    node = ControllerNode(ControllerConfig(robot="test", connect_timeout=0.0), bus, RealClock())
    with pytest.raises(ConnectionFailedError, match="w2c robot --robot test"):
        node.configure()


def test_a_state_that_comes_again_gets_the_same_answer() -> None:
    hub = InProcessHub()
    robot, operator = hub.connect("robot"), hub.connect("operator")
    description = make_description(lock_step=True)
    robot.serve(topics.DESCRIBE, lambda _request, _context: description)
    commands = operator.queue(topics.JOINT_COMMAND)
    node = ControllerNode(ControllerConfig(robot="test"), hub.connect("controller"), RealClock())
    node.configure()
    stop = threading.Event()
    thread = threading.Thread(target=node.run, args=(stop,))
    thread.start()
    try:
        state = Simulator(build_model(None, visuals=False), description).state()
        answers = []
        for _ in range(3):
            robot.publish(topics.ROBOT_STATE, state)
            received = commands.receive(20.0)
            assert received is not None
            answers.append(received.message)
    finally:
        stop.set()
        thread.join(timeout=10.0)
        node.close()
    np.testing.assert_array_equal(answers[0].position, answers[2].position)
    assert [answer.tick for answer in answers] == [0, 0, 0]
