"""The driver that docs/how-to/own-robot.md shows works, with a vendor of ours."""

import re
import sys
import threading
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

from support.documents import ROOT
from support.machines import URDF, ScriptedClock
from w2c import topics
from w2c.bus.inprocess import InProcessHub
from w2c.driver import Driver, Machine
from w2c.errors import ControlError
from w2c.messages import Array, Empty, JointCommand

PAGE = ROOT / "docs" / "how-to" / "own-robot.md"


class Line:
    """A robot with two joints that is at once where it is told to be."""

    def __init__(self) -> None:
        self.position = np.array([0.1, 0.2])
        self.cut_at = 1 << 60
        self.writes = 0
        self.closed = False

    def read(self) -> SimpleNamespace:
        return SimpleNamespace(
            position=self.position,
            velocity=np.zeros(2),
            torque=np.zeros(2),
            sole_wrenches=np.zeros((2, 6)),
            orientation=np.array([0.0, 0.0, 0.0, 1.0]),
            angular_velocity=np.zeros(3),
            acceleration=np.zeros(3),
        )

    def write(self, command: Array) -> bool:
        self.writes += 1
        self.position = command
        return self.writes < self.cut_at

    def close(self) -> None:
        self.closed = True


@pytest.fixture
def line() -> Line:
    return Line()


@pytest.fixture
def machine(line: Line, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Machine:
    """The machine of the page's program."""
    program = re.search(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    assert program is not None
    vendor: Any = ModuleType("vendor")
    vendor.connect = lambda address: line if address == "192.168.1.10" else None
    vendor.JOINTS = [("hip", 5000.0, 100.0), ("rail", 3000.0, 50.0)]
    monkeypatch.setitem(sys.modules, "vendor", vendor)
    names: dict[str, Any] = {"__name__": "my_robot"}
    exec(compile(program[1], str(PAGE), "exec"), names)  # noqa: S102 - our own page
    (tmp_path / "two.urdf").write_text(URDF)
    config = names["MyRobotConfig"](robot="test", urdf=str(tmp_path / "two.urdf"))
    made: Machine = names["MyRobot"](config)
    return made


def run(machine: Machine, hub: InProcessHub, ticks: int) -> None:
    from w2c.driver import DriverConfig

    states = hub.connect("controller").queue(topics.ROBOT_STATE)
    controller = hub.connect("controller")
    stop = threading.Event()

    def act(tick: int) -> None:
        received = states.receive(0.0)
        assert received is not None
        state = received.message
        angles = state.command + np.array([1e-4, 0.0])
        controller.publish(topics.JOINT_COMMAND, JointCommand(tick=state.tick, position=angles))
        if tick == ticks - 1:
            stop.set()

    bus = hub.connect("robot")
    driver = Driver(
        DriverConfig(robot="test", real_time="off"), bus, ScriptedClock(act), lambda: machine
    )
    try:
        driver.configure()
        described = controller.call(topics.DESCRIBE, Empty()).message
        assert [joint.stiffness for joint in described.joints] == [5000.0, 3000.0]
        driver.run(stop)
    finally:
        driver.close()
        bus.close()


def test_the_driver_of_the_page_moves_its_robot(machine: Machine, line: Line) -> None:
    run(machine, InProcessHub(), 20)
    assert line.position == pytest.approx([0.1 + 20e-4, 0.2])
    assert line.closed


def test_the_driver_of_the_page_says_when_its_robot_is_lost(machine: Machine, line: Line) -> None:
    line.cut_at = 5
    with pytest.raises(ControlError, match="does not answer"):
        run(machine, InProcessHub(), 20)
    assert line.closed
