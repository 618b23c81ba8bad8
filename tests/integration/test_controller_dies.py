"""The controller is killed while the robot leans: its successor goes on leaning, without moving."""

import os
import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from support.ports import free_endpoint, free_port
from w2c import topics
from w2c.bus.zenoh_bus import ZenohBus, connect
from w2c.config import ServiceConfig
from w2c.messages import ControllerStatus, Empty, PlaceGoal, ReleaseGoal, Truth
from w2c_launcher.launcher import Launcher
from w2c_launcher.profiles import Options, processes
from w2c_sim_robot.scenes.scenario_a import scenario_a
from w2c_sim_robot.scenes.scene import save

pytestmark = pytest.mark.slow

RIGHT_HAND = 3
PROCESSES = ("router", "robot", "controller")


class RobotHost:
    """Router, robot and controller in lock step, looked after by the launcher."""

    def __init__(self, directory: Path) -> None:
        scene = directory / "scene.json"
        save(scenario_a(), scene)
        options = Options(
            robot="test",
            router=free_endpoint(),
            robot_endpoint=free_endpoint(),
            run_directory=str(directory),
            console_port=free_port(),
            lock_step=True,
            scene=str(scene),
        )
        specs = [spec for spec in processes("simulation", options) if spec.name in PROCESSES]
        self.launcher = Launcher(specs, directory, lambda _name, _phase: None)
        self.config = ServiceConfig(
            robot="test", router=options.router, robot_endpoint=options.robot_endpoint
        )

    def start(self) -> ZenohBus:
        self.launcher.start_stage(0)
        bus = connect(self.config, "evaluation", [self.config.router])
        own = connect(self.config, "launcher", [self.config.router])
        self.launcher.attach(own)
        self._launcher_bus = own
        for stage in (0, 1, 2):
            if stage > 0:
                self.launcher.start_stage(stage)
            self.launcher.wait_ready(stage, lambda: False)
        return bus

    def stop(self) -> None:
        self.launcher.stop()
        self._launcher_bus.close()

    def wait(self, condition: Callable[[], bool], seconds: float) -> None:
        deadline = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < deadline, f"not within {seconds} s"
            self.launcher.watch()

    def pid(self) -> int | None:
        row = next(row for row in self.launcher.table().processes if row.name == "controller")
        return row.pid if row.phase == "ready" else None


@pytest.fixture
def host(tmp_path: Path) -> Iterator[tuple[RobotHost, ZenohBus]]:
    made = RobotHost(tmp_path)
    bus = made.start()
    try:
        yield made, bus
    finally:
        bus.close()
        made.stop()


def test_a_controller_killed_while_leaning_goes_on_from_its_snapshot(
    host: tuple[RobotHost, ZenohBus],
) -> None:
    running, bus = host
    statuses, truths = bus.latest(topics.CONTROLLER_STATUS), bus.latest(topics.TRUTH)
    events = bus.queue(topics.GOAL_EVENT)

    def status() -> ControllerStatus:
        received = statuses.last()
        assert received is not None
        return received.message

    def truth() -> Truth:
        received = truths.last()
        assert received is not None
        return received.message

    def in_phase(*phases: str) -> bool:
        received = statuses.last()
        return received is not None and received.message.phase in phases

    running.wait(lambda: in_phase("hold"), 120)
    goal = PlaceGoal(
        goal_id="lean",
        end_effector="right_hand",
        task="contact",
        point=np.array(scenario_a().object("book").top_in_world),
        normal=np.array([0.0, 0.0, 1.0]),
    )
    bus.call(topics.PLACE, goal)
    running.wait(lambda: in_phase("contact"), 240)
    start = status().tick
    running.wait(lambda: status().tick > start + 4000, 240)

    before, pid = truth(), running.pid()
    assert np.linalg.norm(before.contact_forces[RIGHT_HAND]) > 15.0
    assert pid is not None
    killed_at = status().tick
    os.kill(pid, signal.SIGKILL)
    running.wait(lambda: running.pid() not in (None, pid), 120)
    least, moved = np.inf, 0.0

    def goes_on() -> bool:
        nonlocal least, moved
        now = truth()
        least = min(least, float(np.linalg.norm(now.contact_forces[RIGHT_HAND])))
        way = now.world_from_base[:3] - before.world_from_base[:3]
        moved = max(moved, float(np.abs(way).max()))
        return status().tick > killed_at + 2000

    running.wait(goes_on, 240)
    assert not truth().fell
    assert status().in_contact == (True, True, False, True)
    assert status().phase == "contact" or status().phase == "hold"
    assert least > 10.0
    assert moved < 0.004
    assert bus.call(topics.SNAPSHOT, Empty()).message.state["body"]["@"].endswith("WholeBody")

    while events.receive(0.0) is not None:
        continue
    bus.call(topics.RELEASE, ReleaseGoal(goal_id="back", end_effector="right_hand"))
    running.wait(lambda: in_phase("unload", "retreat"), 60)
