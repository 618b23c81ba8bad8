"""Records a short session on a bus within one process.

    .venv/bin/python tests/replay/record.py controller tests/replay/controller.mcap
    .venv/bin/python tests/replay/record.py perception tests/replay/perception.mcap

controller: with a robot in lock step; a goal over something low, a snapshot that is asked for, a
stop, and what follows a resume. perception: with a robot that sways and a small camera; questions
about a picture. To be made anew when one of them shall answer something else.
"""

import contextlib
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np

from w2c import topics
from w2c.bus import InProcessBus, InProcessHub
from w2c.clock import RealClock
from w2c.errors import RefusedError
from w2c.messages import (
    CameraView,
    Empty,
    HeightField,
    HeightFieldRequest,
    LiftRequest,
    PlaceGoal,
    StopRequest,
)
from w2c_controller.config import ControllerConfig
from w2c_controller.node import ControllerNode
from w2c_perception.config import PerceptionConfig
from w2c_perception.node import PerceptionNode
from w2c_recorder.mcap_file import McapFile
from w2c_sim_robot.camera.config import CameraConfig
from w2c_sim_robot.camera.node import CameraNode
from w2c_sim_robot.config import RobotConfig
from w2c_sim_robot.description import make_description
from w2c_sim_robot.model import build_model
from w2c_sim_robot.node import RobotNode
from w2c_sim_robot.physics import Simulator
from w2c_sim_robot.scenes.scenario_a import scenario_a
from w2c_sim_robot.scenes.scene import Scene, save

ROBOT = "recorded"
GOAL_TICK, SNAPSHOT_TICK, STOP_TICK, RESUME_TICK, LAST_TICK = 15, 50, 80, 90, 130
PIXELS = ((128.0, 100.0), (150.5, 110.25))
PICTURES_HZ = 1.0
SWAY, TURNS = 0.02, 0.003
"""Of all joints [rad], [rad/tick]"""
LEFT_OUT = ("/truth/", "/health/", "/log/", "/statistics")
UP = np.array([0.0, 0.0, 1.0])


def record_controller(hub: InProcessHub, operator: InProcessBus) -> None:
    """Run robot and controller, and ask for this and that, each at about its tick."""
    robot = RobotNode(
        RobotConfig(robot=ROBOT, lock_step=True, noise=1.0), join(hub, "robot"), RealClock()
    )
    controller = ControllerNode(ControllerConfig(robot=ROBOT), join(hub, "controller"), RealClock())
    robot.configure()
    controller.configure()
    states = operator.latest(topics.ROBOT_STATE)

    def wait_for(tick: int) -> None:
        while (last := states.last()) is None or last.message.tick < tick:
            time.sleep(0.001)

    low = HeightField(
        stamp_ns=0, origin=(0.3, 0.1), cell=0.02, heights=np.full((20, 20), 0.7, np.float32)
    )
    goal = PlaceGoal(
        goal_id="reach",
        end_effector="left_hand",
        task="reach",
        point=np.array([0.55, 0.25, 0.95]),
        normal=UP,
        obstacles=low,
    )
    with running(controller.run, robot.run):
        wait_for(GOAL_TICK)
        operator.call(topics.PLACE, goal)
        wait_for(SNAPSHOT_TICK)
        operator.call(topics.SNAPSHOT, Empty())
        wait_for(STOP_TICK)
        operator.call(topics.CONTROLLER_STOP, StopRequest(reason="to be recorded"))
        wait_for(RESUME_TICK)
        operator.call(topics.ROBOT_RESUME, Empty())
        wait_for(LAST_TICK)
    controller.close()
    robot.close()


def record_perception(hub: InProcessHub, operator: InProcessBus) -> None:
    """Run a robot that sways, a camera and perception; ask what is in the second picture."""
    scene = scenario_a()
    with tempfile.TemporaryDirectory() as directory:
        path = Path(directory) / "scene.json"
        save(scene, path)
        perception = PerceptionNode(
            PerceptionConfig(robot=ROBOT), join(hub, "perception"), RealClock()
        )
        camera = CameraNode(
            CameraConfig(robot=ROBOT, scene=str(path), width=256, height=144, rate=PICTURES_HZ),
            join(hub, "camera"),
            RealClock(),
        )

        def see(stop: threading.Event) -> None:
            camera.configure()  # a graphics context belongs to one thread
            camera.run(stop)
            camera.close()

        perception.configure()
        views = operator.queue(topics.CAMERA_VIEW)
        with running(partial(sway, join(hub, "robot"), scene), perception.run, see):
            for _ in range(2):
                view = views.receive(300.0)
            assert view is not None
            ask_perception(operator, view.message)
        perception.close()


def sway(bus: InProcessBus, scene: Scene, stop: threading.Event) -> None:
    """Be a robot whose head and torso turn slowly, and that tells a tenth of its states."""
    description = make_description()
    simulator = Simulator(build_model(scene, visuals=False), description)
    bus.serve(topics.DESCRIBE, lambda _request, _context: description)
    ready = np.array(description.initial_position)
    while not stop.wait(0.02):
        for _ in range(10):
            simulator.step(ready + SWAY * np.sin(TURNS * simulator.tick))
        bus.publish(topics.TRUTH, simulator.truth())
        bus.publish(topics.ROBOT_STATE, simulator.state(command_tick=0, mode="tracking"))


def ask_perception(bus: InProcessBus, view: CameraView) -> None:
    """Ask what is behind some pixels, how high things stand, and something that is refused."""
    stamp_ns, boot_id = view.stamp_ns, view.robot_boot_id
    for u, v in PIXELS:
        request = LiftRequest(u=u, v=v, frame_stamp_ns=stamp_ns, robot_boot_id=boot_id)
        bus.call(topics.LIFT, request)
    bus.call(topics.HEIGHT_FIELD, HeightFieldRequest(frame_stamp_ns=stamp_ns))
    with contextlib.suppress(RefusedError):
        bus.call(topics.LIFT, LiftRequest(u=-1.0, v=0.0, frame_stamp_ns=stamp_ns))


def join(hub: InProcessHub, service: str) -> InProcessBus:
    """Return the bus of a service."""
    return hub.connect(service, robot=ROBOT)


@contextlib.contextmanager
def running(*work: Callable[[threading.Event], None]) -> Iterator[None]:
    """Run nodes on threads of their own."""
    stop = threading.Event()
    threads = [threading.Thread(target=partial(one, stop)) for one in work]
    for thread in threads:
        thread.start()
    try:
        yield
    finally:
        stop.set()
        for thread in threads:
            thread.join()


def main(what: str, path: Path) -> None:
    """Play and record."""
    plays = {"controller": record_controller, "perception": record_perception}
    hub = InProcessHub()
    operator = join(hub, "operator")
    queue = operator.raw_queue("w2c/**")
    plays[what](hub, operator)
    messages = []
    while (received := queue.receive(0.0)) is not None:
        messages.append(received)
    path.unlink(missing_ok=True)
    file = McapFile(path, {"robot": ROBOT, "made_by": f"tests/replay/record.py {what}"})
    for received in messages:
        if not any(part in received.key for part in LEFT_OUT):
            file.write(received, received.received_ns)
    file.close()
    print(f"{path}: {file.messages} messages, {path.stat().st_size / 1e3:.0f} kB")  # noqa: T201


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]))
