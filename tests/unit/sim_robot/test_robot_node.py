"""The driver on the bus: lock step, real time, stop, and what it does with bad commands."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from support.machines import ScriptedClock
from support.waiting import wait_until
from w2c import topics
from w2c.bus.inprocess import InProcessBus, InProcessHub
from w2c.clock import Clock, RealClock
from w2c.errors import ConfigError, RefusedError
from w2c.messages import Array, Empty, JointCommand, PushRequest, RobotState, StopRequest
from w2c_sim_robot.config import RobotConfig
from w2c_sim_robot.node import RobotNode
from w2c_sim_robot.sensor_errors import ForceTorqueErrors, ImuErrors, JointErrors, SensorErrors

Policy = Callable[[RobotState], Array]


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


ALL_ERRORS = SensorErrors(
    position=JointErrors(bias=1e-3, delay_ms=4.0, dropout=0.1),
    soles=ForceTorqueErrors(force_bias=5.0, dropout=0.2),
    imu=ImuErrors(orientation_noise=1e-3, delay_ms=10.0),
)
"""Beside ordinary noise"""


def test_in_lock_step_two_runs_are_identical_to_the_bit() -> None:
    """With everything that draws random numbers, and a push that names its tick."""
    runs = []
    for seed, ticks in ((7, 50), (7, 50), (8, 3)):
        hub = InProcessHub()
        controller, judge = hub.connect("controller"), hub.connect("evaluation")
        with running(hub, lock_step=True, noise=1.0, sensors=ALL_ERRORS, seed=seed):
            force = np.array([0.0, 200.0, 0.0])
            judge.call(topics.PUSH, PushRequest(force=force, duration_s=0.05, tick=20))
            runs.append(answer(controller, ticks, sway))
    assert runs[0][2].position.tolist() != runs[2][2].position.tolist()
    for first, second in zip(*runs[:2], strict=True):
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
        # The last of the answers may still be on its way: it is refused before the robot resumes.
        wait_until(lambda: node.simulator.tick == 5)
        assert node._bus.counters["command refused: stopped"] == 5
        assert operator.call(topics.ROBOT_RESUME, Empty()).message.mode == "holding"
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


def test_a_push_by_a_call_moves_the_robot_from_its_tick_on() -> None:
    hub = InProcessHub()
    controller, judge = hub.connect("controller"), hub.connect("evaluation")
    with running(hub, lock_step=True) as node:
        force = np.array([2000.0, 0.0, 0.0])
        assert judge.call(topics.PUSH, PushRequest(force=force, tick=5)).message.tick == 5
        states = answer(controller, 12, lambda state: state.command)
        # Of the last answer: then time stands still.
        wait_until(lambda: node.simulator.tick == states[-1].tick + 1)
        with pytest.raises(RefusedError, match="tick 3 on is too late"):
            judge.call(topics.PUSH, PushRequest(force=force, tick=3))
        with pytest.raises(RefusedError, match="'operator' may not push"):
            hub.connect("operator").call(topics.PUSH, PushRequest(force=force))
        with pytest.raises(RefusedError, match="no body 'table'"):
            judge.call(topics.PUSH, PushRequest(force=force, link="table"))
        now = judge.call(topics.PUSH, PushRequest(force=force, link="head_2_link")).message.tick
        assert now == node.simulator.tick
    speeds = [float(np.abs(state.velocity).max()) for state in states]
    assert max(speeds[:6]) < 0.05  # settling
    assert speeds[8] > 0.2


def test_a_robot_with_other_flags_is_another_robot() -> None:
    """Every perturbation reaches the simulation, none the description."""
    flags = {
        "stiffness_scale": 0.5,
        "friction_scale": 0.5,
        "ball_friction_scale": 0.5,
        "mass_scale": 1.1,
        "hand_mass": (2.0, 3.0),
        "sole_pitch": (0.02, 0.0),
    }
    hub = InProcessHub()
    with configured(hub, RealClock(), lock_step=True) as node:
        nominal, described = node.simulator.model, node.machine.description
        still = node.simulator.state()
    with configured(hub, RealClock(), lock_step=True, **flags) as node:
        model = node.simulator.model
        assert node.machine.description.urdf == described.urdf
        wrist = node.simulator.state().left_wrist_wrench
    assert model.actuator_gainprm[0, 0] == 0.5 * nominal.actuator_gainprm[0, 0]
    ball, foot = (
        int(model.body(name).geomadr[0]) for name in ("right_hand_frame", "left_sole_link")
    )
    assert model.geom_friction[ball, 0] == pytest.approx(0.25 * nominal.geom_friction[ball, 0])
    assert model.geom_friction[foot, 0] == pytest.approx(0.5 * nominal.geom_friction[foot, 0])
    robot_mass = nominal.body_mass.sum()
    assert model.body_mass.sum() == pytest.approx(1.1 * robot_mass + 5.0)
    assert model.geom_quat[foot].tolist() != nominal.geom_quat[foot].tolist()
    assert np.linalg.norm(still.left_wrist_wrench[:3]) < 0.5
    assert np.linalg.norm(wrist[:3]) == pytest.approx(2.0 * 9.81, abs=0.5)


def test_a_raised_scene_is_raised_in_the_simulation(tmp_path: Path) -> None:
    from w2c_sim_robot.scenes.scenario_a import scenario_a
    from w2c_sim_robot.scenes.scene import save

    scene, path = scenario_a(), tmp_path / "scene.json"
    save(scene, path)
    with configured(InProcessHub(), RealClock(), scene=str(path), table_height=0.03) as node:
        found = node.simulator.truth().scene["cup"][2]
    assert found == pytest.approx(scene.object("cup").position[2] + 0.03)


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        ({"hand_mass": (0.0, 80.0)}, "hand mass 80 kg is outside 0 to 50 kg"),
        ({"sole_pitch": (0.3, 0.0)}, "sole pitch 0.3 rad is beyond"),
        ({"table_height": 0.5}, "table height 0.5 m is beyond 0.2 m"),
        ({"table_height": float("nan")}, "table height nan"),
    ],
)
def test_a_perturbation_beyond_its_limits_is_refused(flags: dict[str, object], words: str) -> None:
    with (
        pytest.raises(ConfigError, match=words),
        configured(InProcessHub(), RealClock(), **flags),
    ):
        pass
