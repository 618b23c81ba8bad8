"""Records a third of a second of robot and controller, in lock step, on a bus within one process.

    .venv/bin/python tests/replay/record.py tests/replay/controller.mcap

A goal over something low, a snapshot that is asked for, a stop, and what follows a resume. It is to
be made anew whenever the controller shall command something else.
"""

import sys
import threading
import time
from pathlib import Path

import numpy as np

from w2c import topics
from w2c.bus import InProcessBus, InProcessHub
from w2c.clock import RealClock
from w2c.messages import Empty, HeightField, PlaceGoal, StopRequest
from w2c_controller.config import ControllerConfig
from w2c_controller.node import ControllerNode
from w2c_recorder.mcap_file import McapFile
from w2c_sim_robot.config import RobotConfig
from w2c_sim_robot.node import RobotNode

GOAL_TICK, SNAPSHOT_TICK, STOP_TICK, RESUME_TICK, LAST_TICK = 15, 50, 80, 90, 130
LEFT_OUT = ("/truth/", "/health/", "/log/")
UP = np.array([0.0, 0.0, 1.0])


def main(path: Path) -> None:
    """Play and record."""
    hub = InProcessHub()
    operator = hub.connect("operator", robot="recorded")
    messages = operator.raw_queue("w2c/**")
    robot = RobotNode(
        RobotConfig(robot="recorded", lock_step=True, noise=1.0),
        hub.connect("robot", robot="recorded"),
        RealClock(),
    )
    robot.configure()
    controller = ControllerNode(
        ControllerConfig(robot="recorded"),
        hub.connect("controller", robot="recorded"),
        RealClock(),
    )
    controller.configure()
    stop = threading.Event()
    threads = [threading.Thread(target=node.run, args=(stop,)) for node in (controller, robot)]
    for thread in threads:
        thread.start()
    try:
        operate(operator)
    finally:
        stop.set()
        for thread in threads:
            thread.join()
        controller.close()
        robot.close()
    path.unlink(missing_ok=True)
    file = McapFile(path, {"robot": "recorded", "made_by": "tests/replay/record.py"})
    while (received := messages.receive(0.0)) is not None:
        if not any(part in received.key for part in LEFT_OUT):
            file.write(received, received.received_ns)
    file.close()
    print(f"{path}: {file.messages} messages, {path.stat().st_size / 1e3:.0f} kB")  # noqa: T201


def operate(bus: InProcessBus) -> None:
    """Ask for this and that, each at about its tick."""
    states = bus.latest(topics.ROBOT_STATE)

    def wait_for(tick: int) -> None:
        while (last := states.last()) is None or last.message.tick < tick:
            time.sleep(0.001)

    wait_for(GOAL_TICK)
    low = HeightField(
        stamp_ns=0, origin=(0.3, 0.1), cell=0.02, heights=np.full((20, 20), 0.7, np.float32)
    )
    bus.call(
        topics.PLACE,
        PlaceGoal(
            goal_id="reach",
            end_effector="left_hand",
            task="reach",
            point=np.array([0.55, 0.25, 0.95]),
            normal=UP,
            obstacles=low,
        ),
    )
    wait_for(SNAPSHOT_TICK)
    bus.call(topics.SNAPSHOT, Empty())
    wait_for(STOP_TICK)
    bus.call(topics.CONTROLLER_STOP, StopRequest(reason="to be recorded"))
    wait_for(RESUME_TICK)
    bus.call(topics.ROBOT_RESUME, Empty())
    wait_for(LAST_TICK)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
