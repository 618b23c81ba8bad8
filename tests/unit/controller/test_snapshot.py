"""A snapshot holds all: another controller that is given it gives the same commands, bit by bit."""

from dataclasses import dataclass, field

import msgspec
import mujoco
import numpy as np
import pytest

from support.leaning import ClosedLoop, place
from w2c.bus.codec import decode_message, encode_message
from w2c.messages import Array, ControllerSnapshot, ReleaseGoal, RobotDescription, RobotState
from w2c_controller.controller import Controller
from w2c_sim_robot.physics import Simulator
from w2c_sim_robot.scenes.scenario_a import scenario_a

BODY = "w2c_controller.whole_body.WholeBody"
TICKS = 80
"""That are compared after each snapshot."""


@dataclass
class Moment:
    """A snapshot and what came after it."""

    payload: bytes
    states: list[RobotState] = field(default_factory=list)
    commands: list[Array] = field(default_factory=list)


def keep(controller: Controller, state: RobotState) -> bytes:
    """Return the bytes of a snapshot, as the node makes it."""
    snapshot = ControllerSnapshot(
        stamp_ns=state.stamp_ns,
        tick=state.tick,
        reason="switch",
        robot_boot_id="robot",
        controller_boot_id="controller",
        phase=controller.phase,
        in_contact=controller.retargeting.state.enabled,
        command=controller.command,
        state=controller.export(),
    )
    return encode_message(snapshot)


class Session(ClosedLoop):
    """A loop that takes a snapshot shortly after each change of phase."""

    def __init__(self, description: RobotDescription) -> None:
        super().__init__(description, scenario_a())
        self.moments: dict[str, Moment] = {}
        self.newest = b""

    def step(self) -> None:
        state = self.simulator.state(command_tick=self._command_tick, mode="tracking")
        command = self.controller.tick(state)
        self._command_tick = command.tick
        self.simulator.step(command.position)
        self.controller.take_events()
        phase = self.controller.phase
        for moment in self.moments.values():
            if len(moment.states) < TICKS:
                moment.states.append(state)
                moment.commands.append(command.position)
        if phase not in self.moments and state.tick % 7 == 0:
            self.newest = keep(self.controller, state)
            self.moments[phase] = Moment(self.newest)

    def run_to(self, phase: str, seconds: float) -> None:
        for _ in range(round(seconds / 0.002)):
            self.step()
            if self.controller.phase == phase:
                return
        raise AssertionError(f"phase {self.controller.phase} after {seconds} s, not {phase}")


@pytest.fixture(scope="module")
def session(description: RobotDescription) -> Session:
    """Leans on the book, until the weight has been shared."""
    session = Session(description)
    session.run_to("hold", 3.0)
    for _ in range(100):
        session.step()
    book = np.array(scenario_a().object("book").top_in_world)
    session.controller.requests.place(place("lean", "right_hand", "contact", book))
    session.run_to("contact", 30.0)
    for _ in range(3500):
        session.step()
    session.moments["leaning"] = Moment(keep(session.controller, session.simulator.state()))
    return session


@pytest.mark.parametrize("phase", ["starting", "hold", "approach", "touch", "load", "contact"])
def test_another_controller_goes_on_bit_by_bit(
    session: Session, description: RobotDescription, phase: str
) -> None:
    moment = session.moments[phase]
    snapshot = decode_message(moment.payload, ControllerSnapshot)
    other = Controller(description)
    other.restore(snapshot.state, moment.states[0])
    assert len(moment.states) >= TICKS
    for state, command in zip(moment.states, moment.commands, strict=True):
        np.testing.assert_array_equal(other.tick(state).position, command)


def test_a_snapshot_is_small(session: Session) -> None:
    assert all(len(moment.payload) < 100_000 for moment in session.moments.values())


def twin(simulator: Simulator, description: RobotDescription) -> Simulator:
    """Return another robot in the same state."""
    made, kind = Simulator(simulator.model, description), mujoco.mjtState.mjSTATE_INTEGRATION
    state = np.zeros(mujoco.mj_stateSize(made.model, kind))
    mujoco.mj_getState(simulator.model, simulator._data, state, kind)
    mujoco.mj_setState(made.model, made._data, state, kind)
    mujoco.mj_forward(made.model, made._data)
    made._command, made._tick = simulator.command, simulator.tick
    return made


class Resumed:
    """A robot that held its last command for a while, and a new controller."""

    def __init__(self, session: Session, holding: Simulator, description: RobotDescription) -> None:
        self.simulator = twin(holding, description)
        self.snapshot = decode_message(session.moments["leaning"].payload, ControllerSnapshot)
        self.command = session.controller.command
        self.controller = Controller(description)
        self._command_tick = 0

    def state(self) -> RobotState:
        return self.simulator.state(command_tick=self._command_tick, mode="tracking")

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / 0.002)):
            command = self.controller.tick(self.state())
            self._command_tick = command.tick
            self.simulator.step(command.position)


@pytest.fixture(scope="module")
def holding(session: Session, description: RobotDescription) -> Simulator:
    """A robot without a controller, for 0.4 s."""
    simulator = twin(session.simulator, description)
    for _ in range(200):
        simulator.step(session.controller.command)
    return simulator


@pytest.fixture
def resumed(session: Session, holding: Simulator, description: RobotDescription) -> Resumed:
    return Resumed(session, holding, description)


def test_a_controller_that_died_leaning_goes_on_leaning_without_moving(resumed: Resumed) -> None:
    before = resumed.simulator.truth()
    resumed.controller.takeover.offer(resumed.snapshot, "robot")
    first = resumed.controller.tick(resumed.state()).position
    np.testing.assert_allclose(first, resumed.command, atol=1e-6)
    assert resumed.controller.snapshot().in_contact == (True, True, False, True)
    resumed.run(4.0)
    after = resumed.simulator.truth()
    assert np.abs(after.world_from_base[:3] - before.world_from_base[:3]).max() < 0.003
    assert np.linalg.norm(after.contact_forces[3]) > 10.0
    assert not resumed.simulator.fell
    assert resumed.controller.retargeting.failures == 0
    resumed.controller.requests.release(ReleaseGoal(goal_id="r", end_effector="right_hand"))
    resumed.run(0.1)
    assert resumed.controller.phase == "unload"


def test_without_a_snapshot_it_holds_and_asks(resumed: Resumed) -> None:
    for _ in range(50):
        answer = resumed.controller.tick(resumed.state())
        np.testing.assert_array_equal(answer.position, resumed.state().command)
        resumed.simulator.step(answer.position)
    summary = resumed.controller.snapshot()
    assert summary.phase == "held"
    assert "w2c resume" in summary.message
    (report,) = resumed.controller.take_safety_reports()
    assert report.hazard.cause == "no_snapshot"
    resumed.controller.resume()
    resumed.run(0.1)
    assert resumed.controller.snapshot().in_contact == (True, True, False, True)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"robot_boot_id": "other"}, "the robot was restarted"),
        ({"tick": 10**9}, "the robot is at"),
        ({"command": np.zeros(3)}, "a robot with 3 joints"),
        ({"command": np.full(27, 3.0)}, "limit 0.5 rad"),
        ({"in_contact": (True, True, True, True)}, "bears"),
        ({"state": {"body": {"@": "w2c_controller.controller.Other"}}}, "is of a"),
        ({"state": {"body": {"@": BODY, "x": {"@": "os.X"}}}}, "os.X"),
    ],
)
def test_a_snapshot_that_does_not_fit_is_not_used(
    resumed: Resumed, changes: dict[str, object], reason: str
) -> None:
    resumed.controller.takeover.offer(msgspec.structs.replace(resumed.snapshot, **changes), "robot")
    resumed.controller.tick(resumed.state())
    assert reason in resumed.controller.snapshot().message
    assert resumed.controller.snapshot().phase == "held"
