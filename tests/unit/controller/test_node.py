"""The node on a bus, with a robot that answers as the driver does."""

import threading
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import msgspec
import numpy as np
import pytest

from support.waiting import wait_until
from w2c import topics
from w2c.bus import InProcessHub
from w2c.bus.codec import decode_message
from w2c.clock import RealClock
from w2c.errors import ConnectionFailedError, RefusedError, UnavailableError
from w2c.messages import (
    ControllerSnapshot,
    ControllerStatus,
    Empty,
    PlaceGoal,
    ReleaseGoal,
    StopRequest,
)
from w2c_controller.config import ControllerConfig
from w2c_controller.node import ControllerNode
from w2c_controller.preview.search import StaticSearch
from w2c_recorder.mcap_file import McapFile
from w2c_recorder.through.commands import compare
from w2c_recorder.through.options import ThroughOptions
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
    standing = cell.wait_status("hold")
    assert standing.soles is not None
    assert standing.soles[:, :3] == pytest.approx(standing.end_effector_positions[:2])
    assert standing.soles[:, :3].sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-6)
    assert np.abs(standing.soles[:, 6]) == pytest.approx(np.ones(2), abs=1e-3)
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


class Wire:
    """A node in real time, and a robot whose every state is made by hand."""

    def __init__(self, directory: Path) -> None:
        hub = InProcessHub()
        self.robot, self.operator = hub.connect("robot"), hub.connect("operator")
        self.description = make_description(lock_step=False)
        self.robot.serve(topics.DESCRIBE, lambda _request, _context: self.description)
        self.events = self.operator.queue(topics.SAFETY_EVENT)
        self.statistics = self.operator.queue(topics.CONTROLLER_STATISTICS)
        self.commands = self.operator.queue(topics.JOINT_COMMAND)
        config = ControllerConfig(
            robot="test", real_time="off", stale_ms=200.0, run_directory=str(directory)
        )
        self.bus = hub.connect("controller")
        self.node = ControllerNode(config, self.bus, RealClock())
        self.node.configure()
        self.simulator = Simulator(build_model(None, visuals=False), self.description)
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self.node.run, args=(self._stop,))
        self._thread.start()

    def close(self) -> None:
        self._stop.set()
        self._thread.join(timeout=10.0)
        self.node.close()

    def send(self, tick: int) -> None:
        state = self.simulator.state(command_tick=tick - 1, mode="tracking")
        stamp_ns = tick * self.description.period_ns
        state = msgspec.structs.replace(state, tick=tick, stamp_ns=stamp_ns)
        self.robot.publish(topics.ROBOT_STATE, state)

    def answer(self, tick: int) -> int:
        """Return the tick that the next command answers."""
        self.send(tick)
        received = self.commands.receive(30.0)
        assert received is not None
        return received.message.tick

    def is_silent(self, tick: int) -> bool:
        """Return whether a tick is not answered."""
        self.send(tick)
        return self.commands.receive(0.5) is None

    def event(self) -> tuple[str, str]:
        received = self.events.receive(5.0)
        assert received is not None
        return received.message.cause, received.message.state

    def wait_event(self, cause: str, state: str) -> None:
        while self.event() != (cause, state):
            pass


@pytest.fixture
def wire(tmp_path: Path) -> Iterator[Wire]:
    made = Wire(tmp_path)
    yield made
    made.close()


def test_without_states_it_says_so_and_goes_on_with_the_next(wire: Wire) -> None:
    assert wire.answer(1) == 1
    assert wire.event() == ("state_stale", "begins")
    with pytest.raises(RefusedError, match="stale"):
        wire.operator.call(topics.PLACE, _reach((0.6, 0.3, 1.0)))
    assert wire.answer(2) == 2
    assert wire.event() == ("state_stale", "ends")


def test_a_state_out_of_order_is_told_and_not_answered(wire: Wire) -> None:
    assert wire.answer(10) == 10
    assert wire.is_silent(9)
    assert wire.answer(11) == 11
    told = {wire.event() for _ in range(2)}
    assert ("state_out_of_order", "begins") in told or wire.event()[0] == "state_out_of_order"
    assert wire.bus.counters["state out of order"] == 1


def test_what_the_process_found_by_its_clock_is_made_again_from_the_recording(
    wire: Wire, tmp_path: Path
) -> None:
    heard = wire.operator.raw_queue("w2c/**")
    wire.operator.call(topics.DESCRIBE, Empty())
    assert [wire.answer(tick) for tick in (24, 25)] == [24, 25]
    wire.wait_event("state_stale", "begins")  # at a tick that has a status of its own
    wire.send(24)
    wire.wait_event("state_out_of_order", "begins")  # told in a second silence
    assert [wire.answer(tick) for tick in (26, 27)] == [26, 27]
    wire.close()
    file, kinds = McapFile(tmp_path / "session.mcap", {}), Counter[str]()
    while (received := heard.receive(0.0)) is not None:
        file.write(received, received.received_ns)
        kinds["/".join(received.key.split("/")[-3:])] += 1
    file.close()
    report = compare(file.path, ThroughOptions(service="controller"))
    assert report.status == 0, "\n".join(report.lines)
    for stream, count in report.values["outputs"].items():
        assert count["equal"] == kinds[stream], "\n".join(report.lines)
    assert kinds["event/controller/safety"] >= 4
    assert kinds["state/controller/status"] >= 3


def test_statistics_and_snapshots_come_from_the_loop(wire: Wire, tmp_path: Path) -> None:
    for tick in (1, 2, 5, 250):
        assert wire.answer(tick) == tick
    received = wire.statistics.receive(5.0)
    assert received is not None
    statistics = received.message
    assert statistics.ticks == 4
    assert statistics.skipped_ticks == 246
    assert statistics.lateness_counts.sum() == statistics.ticks
    assert statistics.duration_counts.sum() == statistics.ticks
    assert statistics.retargeting.solved >= 4
    assert statistics.collections == 0
    assert not statistics.memory_locked
    file = tmp_path / "controller_snapshot.msgpack"
    wait_until(file.is_file, 5.0)
    kept = decode_message(file.read_bytes(), ControllerSnapshot)
    assert kept.tick == 1
    assert kept.reason == "switch"
    assert kept.controller_boot_id == wire.bus.boot_id
    replies: list[ControllerSnapshot] = []
    asking = threading.Thread(
        target=lambda: replies.append(wire.operator.call(topics.SNAPSHOT, Empty()).message)
    )
    asking.start()
    tick = 251
    while asking.is_alive():
        wire.send(tick)
        tick += 1
        asking.join(timeout=0.02)
    assert replies[0].reason == "request"
    assert replies[0].tick > 250


def test_a_stop_that_does_not_reach_the_driver_is_told_and_ends_with_resume(wire: Wire) -> None:
    assert wire.answer(1) == 1
    with pytest.raises(UnavailableError, match="the controller holds, but the driver"):
        wire.operator.call(topics.CONTROLLER_STOP, StopRequest(reason="test"))
    assert wire.answer(2) == 2
    assert wire.node.controller.phase == "stopped"
    assert wire.operator.call(topics.CONTROLLER_RESUME, Empty()).message.holding
    assert wire.answer(3) == 3
    assert wire.node.controller.phase != "stopped"
    assert not wire.operator.call(topics.CONTROLLER_RESUME, Empty()).message.holding
