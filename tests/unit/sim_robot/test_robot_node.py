"""The driver on the bus: lock step, real time, stop, and what it does with bad commands."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from support.waiting import wait_until
from w2c import topics
from w2c.bus.inprocess import InProcessBus, InProcessHub
from w2c.clock import Clock, RealClock
from w2c.errors import ConfigError
from w2c.messages import Array, Empty, JointCommand, RobotState, StopRequest
from w2c_sim_robot.config import RobotConfig
from w2c_sim_robot.node import RobotNode

Policy = Callable[[RobotState], Array]


class ScriptedClock:
    """A clock that jumps to each deadline and lets the test act there, in the node's own thread."""

    def __init__(self, at_tick: Callable[[int], None]) -> None:
        self._now_ns = 0
        self._at_tick = at_tick
        self._sleeps = 0

    def now_ns(self) -> int:
        """Return the time of the last deadline [ns]."""
        return self._now_ns

    def sleep_until(self, deadline_ns: int) -> None:
        """Jump there; the test acts."""
        self._now_ns = deadline_ns
        self._at_tick(self._sleeps)
        self._sleeps += 1


@contextmanager
def configured(hub: InProcessHub, clock: Clock, **flags: object) -> Iterator[RobotNode]:
    """Yield a node that answers calls but does not run yet."""
    bus = hub.connect("robot")
    node = RobotNode(RobotConfig(robot="test", **flags), bus, clock)  # type: ignore[arg-type]
    try:
        node.configure()
        yield node
    finally:
        node.close()
        bus.close()


@contextmanager
def running(hub: InProcessHub, **flags: object) -> Iterator[RobotNode]:
    """Yield a node that runs in a thread."""
    with configured(hub, RealClock(), **flags) as node:
        stop = threading.Event()
        thread = threading.Thread(target=node.run, args=(stop,))
        thread.start()
        try:
            yield node
        finally:
            stop.set()
            thread.join(10.0)
            assert not thread.is_alive()


def answer(bus: InProcessBus, ticks: int, policy: Policy) -> list[RobotState]:
    """Answer a robot in lock step for some ticks. Returns the states."""
    states = bus.queue(topics.ROBOT_STATE)
    seen: list[RobotState] = []
    while len(seen) < ticks:
        received = states.receive(10.0)
        assert received is not None
        state = received.message
        if seen and state.tick <= seen[-1].tick:
            continue
        seen.append(state)
        bus.publish(topics.JOINT_COMMAND, JointCommand(tick=state.tick, position=policy(state)))
    return seen


def sway(state: RobotState) -> Array:
    """Nod, starting from the command in force."""
    command = state.command.copy()
    command[-2] -= 2e-4
    return command


def test_describes_itself() -> None:
    hub = InProcessHub()
    with configured(hub, RealClock(), lock_step=True):
        description = hub.connect("controller").call(topics.DESCRIBE, Empty()).message
    assert description.lock_step
    assert len(description.joints) == 27


def test_in_lock_step_time_stands_still_until_the_answer_comes() -> None:
    hub = InProcessHub()
    controller = hub.connect("controller")
    with running(hub, lock_step=True) as node:
        # The first state was lost on nobody: it is sent again to a controller that comes late.
        states = answer(controller, 20, sway)
        assert [state.tick for state in states] == list(range(20))
        wait_until(lambda: node.simulator.tick == 20)
    assert node.simulator.tick == 20
    assert [state.stamp_ns for state in states] == [2_000_000 * tick for tick in range(20)]
    assert [state.command_tick for state in states] == list(range(-1, 19))
    assert [state.mode for state in states] == ["holding"] + 19 * ["tracking"]


def test_in_lock_step_two_runs_are_identical_to_the_bit() -> None:
    runs = []
    for _ in range(2):
        hub = InProcessHub()
        with running(hub, lock_step=True, noise=1.0, seed=7):
            runs.append(answer(hub.connect("controller"), 100, sway))
    for first, second in zip(*runs, strict=True):
        for name in RobotState.__struct_fields__:
            a, b = getattr(first, name), getattr(second, name)
            same = a.tobytes() == b.tobytes() if isinstance(a, np.ndarray) else a == b
            assert same, (first.tick, name)


def test_in_lock_step_a_bad_answer_is_counted_and_the_robot_holds() -> None:
    hub = InProcessHub()
    bus = hub.connect("controller")

    def jump_at_5(state: RobotState) -> Array:
        command = state.command.copy()
        if state.tick == 5:
            command[3] += 0.5
        return command[:26] if state.tick == 6 else command

    with running(hub, lock_step=True) as node:
        states = answer(bus, 10, jump_at_5)
        wait_until(lambda: node.simulator.tick == 10)
        counters = node._bus.counters
    assert counters["command refused: jump"] == 1
    assert counters["command refused: length"] == 1
    assert [state.command_tick for state in states[5:9]] == [4, 4, 4, 7]
    assert states[-1].command.tolist() == states[0].command.tolist()


def test_in_lock_step_answers_to_other_ticks_are_counted_and_ignored() -> None:
    hub = InProcessHub()
    bus = hub.connect("controller")
    with running(hub, lock_step=True) as node:
        held = node.simulator.command
        for tick in (7, 3):
            bus.publish(topics.JOINT_COMMAND, JointCommand(tick=tick, position=held))
        wait_until(lambda: node._bus.counters.get("command of another tick", 0) == 2)
        assert node.simulator.tick == 0


def test_stop_is_served_while_lock_step_waits_and_outlives_commands_until_resumed() -> None:
    hub = InProcessHub()
    controller, operator = hub.connect("controller"), hub.connect("operator")
    with running(hub, lock_step=True) as node:
        for _ in range(2):
            reply = operator.call(topics.ROBOT_STOP, StopRequest(reason="test")).message
            assert reply.mode == "stopped"
        states = answer(controller, 5, sway)
        assert {state.mode for state in states} == {"stopped"}
        assert states[-1].command.tolist() == states[0].command.tolist()
        assert node._bus.counters["command refused: stopped"] >= 4
        assert operator.call(topics.ROBOT_RESUME, Empty()).message.mode == "holding"
        wait_until(lambda: node.simulator.tick == 5)
        assert answer(controller, 2, sway)[-1].mode == "tracking"


def test_in_real_time_the_driver_tracks_then_holds_when_commands_stop_coming() -> None:
    hub = InProcessHub()
    controller = hub.connect("controller")
    states = controller.queue(topics.ROBOT_STATE)
    truths = controller.queue(topics.TRUTH)
    stop = threading.Event()

    def act(tick: int) -> None:
        received = states.receive(0.0)
        assert received is not None
        modes.append(received.message.mode)
        assert received.message.tick == tick
        if tick < 20:
            command = JointCommand(tick=tick, position=received.message.command)
            controller.publish(topics.JOINT_COMMAND, command, [received.as_input()])
        if tick == 60:
            stop.set()

    modes: list[str] = []
    with configured(hub, ScriptedClock(act)) as node:
        node.run(stop)
    # The last command answers tick 19 and is 25 ticks (50 ms) old at tick 44.
    assert modes[0] == "holding"
    assert set(modes[1:46]) == {"tracking"}
    assert set(modes[46:]) == {"holding"}
    ticks = []
    while (truth := truths.receive(0.0)) is not None:
        ticks.append(truth.message.tick)
    assert ticks == [0, 17, 34, 51]  # 30 Hz


def test_state_says_which_command_it_was_computed_from() -> None:
    hub = InProcessHub()
    controller = hub.connect("controller")
    with running(hub, lock_step=True):
        answer(controller, 3, sway)
        received = controller.queue(topics.ROBOT_STATE).receive(5.0)
    assert received is not None
    assert [entry.key for entry in received.envelope.inputs] == [topics.JOINT_COMMAND.key("test")]


def test_a_missing_scene_is_a_clear_error(tmp_path: Path) -> None:
    with (
        pytest.raises(ConfigError, match="no scene file"),
        configured(InProcessHub(), RealClock(), scene=str(tmp_path / "none.json")),
    ):
        pass
