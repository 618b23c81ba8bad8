"""The robot driver as a process of its own, the hub of its host: no router runs here."""

import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from support.ports import free_endpoint
from support.waiting import wait_until
from w2c import topics
from w2c.bus.zenoh_bus import connect
from w2c.config import ServiceConfig
from w2c.messages import Empty, JointCommand, StopRequest

pytestmark = pytest.mark.real_time


@contextmanager
def robot_process(config: ServiceConfig, *flags: str) -> Iterator[subprocess.Popen[bytes]]:
    """Yield a running driver; it must end well at SIGTERM."""
    command = [
        *(sys.executable, "-m", "w2c_sim_robot", "--robot", config.robot),
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


def test_a_controller_steps_the_robot_and_stop_works_without_router_and_controller() -> None:
    config = ServiceConfig(robot="alone", router=free_endpoint(), robot_endpoint=free_endpoint())
    with robot_process(config, "--lock-step"):
        with connect(config, "controller", [config.robot_endpoint]) as controller:
            controller.use_lock_step()
            states = controller.queue(topics.ROBOT_STATE)
            wait_until(lambda: ("robot", "0") in controller.alive())
            description = controller.call(topics.DESCRIBE, Empty(), timeout_s=20.0).message
            assert description.lock_step
            ticks: list[int] = []
            while len(ticks) < 200:
                received = states.receive(10.0)
                assert received is not None
                state = received.message
                if state.tick in ticks:  # sent again, before the first answer came
                    continue
                ticks.append(state.tick)
                answer = JointCommand(tick=state.tick, position=state.command)
                controller.publish(topics.JOINT_COMMAND, answer, [received.as_input()])
            assert ticks == list(range(200))
            assert state.mode == "tracking"
        with connect(config, "operator", [config.robot_endpoint]) as operator:
            wait_until(lambda: ("robot", "0") in operator.alive())
            reply = operator.call(topics.ROBOT_STOP, StopRequest(reason="test")).message
            assert reply.mode == "stopped"


def test_bad_flags_end_with_status_2(tmp_path: object) -> None:
    missing = f"{tmp_path}/none.json"
    endpoints = ["--router", free_endpoint(), "--robot-endpoint", free_endpoint()]
    for flags in (["--scene", missing], ["--stiffness-scale", "0"], ["--no-such-flag"]):
        command = [sys.executable, "-m", "w2c_sim_robot", "--robot", "alone", *endpoints, *flags]
        done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
        assert done.returncode == 2, done.stderr
        assert "Traceback" not in done.stderr
