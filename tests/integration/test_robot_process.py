"""The robot driver as a process of its own, the hub of its host: no router runs here."""

import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from support.machines import recorded_session
from support.ports import free_endpoint
from support.recordings import write_recording
from support.waiting import wait_until
from w2c import topics
from w2c.bus import Bus
from w2c.bus.zenoh_bus import connect
from w2c.config import ServiceConfig
from w2c.errors import UnavailableError
from w2c.messages import Empty, JointCommand, PushRequest, RobotDescription, StopRequest

pytestmark = pytest.mark.real_time


@contextmanager
def robot_process(
    config: ServiceConfig, *flags: str, module: str = "w2c_sim_robot"
) -> Iterator[subprocess.Popen[bytes]]:
    """Yield a running driver; it must end well at SIGTERM."""
    command = [
        *(sys.executable, "-m", module, "--robot", config.robot),
        *("--router", config.router, "--robot-endpoint", config.robot_endpoint),
        *flags,
    ]
    process = subprocess.Popen(command)
    try:
        yield process
        process.send_signal(signal.SIGTERM)
        assert process.wait(10.0) == 0
    finally:
        process.kill()
        process.wait()


def describe(bus: Bus) -> RobotDescription:
    """Return what the robot says of itself, when it has been built."""
    replies: list[RobotDescription] = []

    def answered() -> bool:
        try:
            replies.append(bus.call(topics.DESCRIBE, Empty(), timeout_s=20.0).message)
        except UnavailableError:
            return False
        return True

    wait_until(answered, 40.0)
    return replies[0]


def test_a_controller_steps_the_robot_and_stop_works_without_router_and_controller() -> None:
    config = ServiceConfig(robot="alone", router=free_endpoint(), robot_endpoint=free_endpoint())
    with robot_process(config, "--lock-step", "--sensors.position.bias", "0.01"):
        with connect(config, "controller", [config.robot_endpoint]) as controller:
            controller.use_lock_step()
            states = controller.queue(topics.ROBOT_STATE)
            description = describe(controller)
            assert description.lock_step
            ticks: list[int] = []
            while len(ticks) < 200:
                received = states.receive(10.0)
                assert received is not None
                state = received.message
                if state.tick in ticks:  # sent again, before the first answer came
                    continue
                if not ticks:
                    bias = state.position - description.initial_position
                    assert 1e-3 < abs(bias).max() <= 0.01
                ticks.append(state.tick)
                answer = JointCommand(tick=state.tick, position=state.command)
                controller.publish(topics.JOINT_COMMAND, answer, [received.as_input()])
            assert ticks == list(range(200))
            assert state.mode == "tracking"
        with connect(config, "operator", [config.robot_endpoint]) as operator:
            wait_until(lambda: ("robot", "0") in operator.alive())
            reply = operator.call(topics.ROBOT_STOP, StopRequest(reason="test")).message
            assert reply.mode == "stopped"
        with connect(config, "evaluation", [config.robot_endpoint]) as judge:
            wait_until(lambda: ("robot", "0") in judge.alive())
            push = PushRequest(force=np.array([20.0, 0.0, 0.0]))
            assert judge.call(topics.PUSH, push).message.tick == 200


def test_a_recorded_session_takes_the_place_of_the_robot(tmp_path: Path) -> None:
    path = tmp_path / "session.mcap"
    write_recording(path, recorded_session(range(1000)))
    config = ServiceConfig(robot="again", router=free_endpoint(), robot_endpoint=free_endpoint())
    flags = ("--recording", str(path), "--repeat")
    with (
        robot_process(config, *flags, module="w2c_sim_robot.recorded"),
        connect(config, "operator", [config.robot_endpoint]) as operator,
    ):
        states = operator.queue(topics.ROBOT_STATE)
        described = describe(operator)
        assert [joint.name for joint in described.joints] == ["hip", "rail"]
        for _ in range(20):
            received = states.receive(10.0)
            assert received is not None
            state = received.message
            assert float(state.position[0]) == pytest.approx(1e-3 * (state.tick % 1000))
        reply = operator.call(topics.ROBOT_STOP, StopRequest(reason="test")).message
        assert reply.mode == "stopped"


def test_a_recording_that_cannot_be_played_ends_with_a_reason(tmp_path: Path) -> None:
    (tmp_path / "song.mcap").write_bytes(b"RIFF" + bytes(100))
    endpoints = ["--router", free_endpoint(), "--robot-endpoint", free_endpoint()]
    command = [sys.executable, "-m", "w2c_sim_robot.recorded", "--robot", "again", *endpoints]
    command += ["--recording", str(tmp_path / "song.mcap")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 1
    assert "song.mcap" in done.stderr
    assert "Traceback" not in done.stderr


def test_bad_flags_end_with_status_2(tmp_path: Path) -> None:
    missing = f"{tmp_path}/none.json"
    endpoints = ["--router", free_endpoint(), "--robot-endpoint", free_endpoint()]
    for flags in (["--scene", missing], ["--stiffness-scale", "0"], ["--no-such-flag"]):
        command = [sys.executable, "-m", "w2c_sim_robot", "--robot", "alone", *endpoints, *flags]
        done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
        assert done.returncode == 2, done.stderr
        assert "Traceback" not in done.stderr
