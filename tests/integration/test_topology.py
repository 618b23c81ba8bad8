"""Who hears whom while router and controller die: the topology of docs/explanation/topology.md."""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager

import numpy as np
import pytest

from support.ports import free_endpoint
from support.waiting import wait_until
from w2c import topics
from w2c.bus.zenoh_bus import ZenohBus, connect, connect_hub
from w2c.config import ServiceConfig
from w2c.messages import JointCommand, RobotState, StopReply, StopRequest

pytestmark = pytest.mark.real_time

CONTROLLER = """
import sys, time
import numpy as np
from w2c import topics
from w2c.bus.zenoh_bus import connect
from w2c.config import ServiceConfig
from w2c.messages import JointCommand
config = ServiceConfig(robot="test", robot_endpoint=sys.argv[1])
with connect(config, "controller", [config.robot_endpoint]) as bus:
    states = bus.queue(topics.ROBOT_STATE)
    print("connected", flush=True)
    while True:
        state = states.receive(1.0)
        if state is not None:
            command = JointCommand(tick=state.message.tick, position=np.zeros(2))
            bus.publish(topics.JOINT_COMMAND, command)
"""


@contextmanager
def process(*command: str) -> "Iterator[subprocess.Popen[str]]":
    """Run a process, kill it in the end."""
    with subprocess.Popen([sys.executable, *command], stdout=subprocess.PIPE, text=True) as running:
        try:
            yield running
        finally:
            running.kill()


class Robot:
    """The hub: publishes states, counts the commands that come back."""

    def __init__(self, bus: ZenohBus) -> None:
        self._bus = bus
        self._tick = 0
        self._commands = bus.queue(topics.JOINT_COMMAND)

    def publish(self) -> int:
        self._tick += 1
        zero = np.zeros(2)
        state = RobotState(
            stamp_ns=self._tick,
            tick=self._tick,
            position=zero,
            velocity=zero,
            torque=zero,
            sole_wrenches=np.zeros((2, 6)),
            left_wrist_wrench=np.zeros(6),
            imu_orientation=np.zeros(4),
            imu_angular_velocity=np.zeros(3),
            imu_linear_acceleration=np.zeros(3),
            command=zero,
            command_tick=-1,
            mode="tracking",
        )
        self._bus.publish(topics.ROBOT_STATE, state)
        return self._tick

    def exchange(self, count: int) -> int:
        """Publish states one by one; return how many were answered with a command."""
        answered = 0
        for _ in range(count):
            tick = self.publish()
            received = self._commands.receive(1.0)
            while received is not None and received.message.tick < tick:
                received = self._commands.receive(1.0)
            answered += received is not None
        return answered

    def is_answered(self) -> bool:
        return self.exchange(1) == 1


@pytest.fixture
def config() -> ServiceConfig:
    """Endpoints of a private system."""
    return ServiceConfig(
        robot="test", router=free_endpoint(), robot_endpoint=free_endpoint(), connect_timeout=10.0
    )


def start_router(config: ServiceConfig) -> AbstractContextManager["subprocess.Popen[str]"]:
    return process("-m", "w2c.cli", "router", "--listen", config.router)


def test_robot_and_controller_go_on_without_the_router_and_all_heal(config: ServiceConfig) -> None:
    """50 of 50 states reach the recorder; stop is answered at the robot itself."""
    with connect_hub(config, "robot") as hub, process("-c", CONTROLLER, config.robot_endpoint):
        robot = Robot(hub)
        with start_router(config):
            recorder_bus = connect(config, "recorder", [config.router])
            with recorder_bus as recorder:
                heard = recorder.queue(topics.ROBOT_STATE)
                commands = recorder.queue(topics.JOINT_COMMAND)
                wait_until(robot.is_answered)
                wait_until(lambda: robot.is_answered() and heard.receive(0.05) is not None)
                wait_until(lambda: robot.is_answered() and commands.receive(0.05) is not None)
        assert robot.exchange(50) == 50
        with start_router(config), connect(config, "recorder", [config.router]) as recorder:
            heard = recorder.queue(topics.ROBOT_STATE)
            wait_until(lambda: robot.is_answered() and heard.receive(0.05) is not None)


def test_the_robot_is_seen_and_stopped_with_the_controller_dead(config: ServiceConfig) -> None:
    """50 of 50 states reach the recorder; stop is answered on the robot's own endpoint."""
    with start_router(config), connect_hub(config, "robot") as hub:
        robot = Robot(hub)
        hub.serve(topics.ROBOT_STOP, lambda request, context: StopReply(mode="stopped", stamp_ns=1))
        with connect(config, "recorder", [config.router]) as recorder:
            heard = recorder.queue(topics.ROBOT_STATE)
            with process("-c", CONTROLLER, config.robot_endpoint):
                wait_until(robot.is_answered)
            wait_until(lambda: ("controller", "0") not in hub.alive())
            wait_until(lambda: robot.publish() > 0 and heard.receive(0.1) is not None)
            while heard.receive(0.2) is not None:
                pass
            for _ in range(50):
                robot.publish()
            received = [heard.receive(5.0) for _ in range(50)]
            assert sum(r is not None for r in received) == 50
            with connect(config, "operator", [config.robot_endpoint]) as operator:
                assert operator.call(topics.ROBOT_STOP, StopRequest()).message.mode == "stopped"
            assert recorder.call(topics.ROBOT_STOP, StopRequest()).message.mode == "stopped"


def test_clients_of_the_router_hear_each_other_and_dial_one_way(config: ServiceConfig) -> None:
    with (
        start_router(config),
        connect_hub(config, "robot") as hub,
        connect(config, "dialogue", [config.router]) as dialogue,
        connect(config, "llm", [config.router]) as llm,
    ):
        wait_until(lambda: ("llm", "0") in dialogue.alive())
        wait_until(lambda: ("robot", "0") in llm.alive())
        assert len(dialogue.links) == 1
        assert len(llm.links) == 1
        wait_until(lambda: len(hub.links) == 1)


def test_a_command_reaches_the_robot_only_from_its_own_endpoint_or_the_router(
    config: ServiceConfig,
) -> None:
    with (
        connect_hub(config, "robot") as hub,
        connect(config, "controller", [config.robot_endpoint]) as controller,
    ):
        commands = hub.queue(topics.JOINT_COMMAND)

        def arrives() -> bool:
            controller.publish(topics.JOINT_COMMAND, JointCommand(tick=1, position=np.zeros(2)))
            return commands.receive(0.05) is not None

        wait_until(arrives)
