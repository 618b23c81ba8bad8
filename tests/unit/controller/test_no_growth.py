"""After warm-up the loop neither grows nor wakes the garbage collector."""

import gc
import sys
import threading
import time
from collections.abc import Callable

import msgspec
import pytest

from fakes.ideal_robot import IdealRobot
from w2c import topics
from w2c.bus import InProcessHub
from w2c.clock import RealClock
from w2c.messages import Array, RobotDescription, RobotState
from w2c.realtime import collector_off
from w2c_controller.config import ControllerConfig
from w2c_controller.controller import Controller
from w2c_controller.node import ControllerNode

TICKS = 10_000
ANSWERS = 3_000
"""On the bus a tick takes three times as long, and a leak of one block in thirty still shows."""
SETTLE_S = 0.3
"""Until all that the loop handed over has been published."""
MOST_BLOCKS = 100


class Follower:
    """A robot that is where it was told to be; it makes a state without keeping anything."""

    def __init__(self, description: RobotDescription) -> None:
        self._state = IdealRobot(description).state()

    def state(self) -> RobotState:
        return self._state

    def follow(self, command: Array) -> None:
        self._state = msgspec.structs.replace(
            self._state,
            tick=self._state.tick + 1,
            stamp_ns=self._state.stamp_ns + 2_000_000,
            position=command,
            command=command,
            command_tick=self._state.tick,
            mode="tracking",
        )


def check_growth(tick: Callable[[int], None], collections: Callable[[], int], count: int) -> None:
    """Fail where ticks keep memory, leave garbage, or run the collector.

    A collection by hand also empties the interpreter's lists of free objects, which grow to a bound
    of their own and are counted as allocated.
    """
    tick(count // 5)
    time.sleep(SETTLE_S)
    gc.collect()
    before, runs = sys.getallocatedblocks(), collections()
    tick(count)
    time.sleep(SETTLE_S)
    assert collections() == runs
    assert gc.collect() == 0, "reference counts alone must free what a tick drops"
    grown = sys.getallocatedblocks() - before
    assert grown <= MOST_BLOCKS


@pytest.mark.slow
def test_ten_thousand_ticks_keep_no_memory_and_no_garbage(description: RobotDescription) -> None:
    controller, robot = Controller(description), Follower(description)

    def step(ticks: int) -> None:
        for _ in range(ticks):
            robot.follow(controller.tick(robot.state()).position)
            controller.take_events()

    with collector_off() as watch:
        check_growth(step, lambda: watch.runs, TICKS)


@pytest.mark.slow
def test_three_thousand_answers_on_the_bus_keep_no_memory(description: RobotDescription) -> None:
    """Decoding, ticking, publishing, reports and snapshots: all that the process does in a tick."""
    hub = InProcessHub()
    robot = hub.connect("robot")
    robot.serve(topics.DESCRIBE, lambda _request, _context: description)
    node = ControllerNode(ControllerConfig(robot="test"), hub.connect("controller"), RealClock())
    node.configure()
    stop = threading.Event()
    thread = threading.Thread(target=node.run, args=(stop,))
    thread.start()
    commands = robot.latest(topics.JOINT_COMMAND)
    follower = Follower(description)

    def answer(ticks: int) -> None:
        for _ in range(ticks):
            robot.publish(topics.ROBOT_STATE, follower.state())
            received = commands.wait(30.0)
            assert received is not None
            follower.follow(received.message.position)

    try:
        check_growth(answer, lambda: node.collections, ANSWERS)
    finally:
        stop.set()
        thread.join(timeout=10.0)
        node.close()
