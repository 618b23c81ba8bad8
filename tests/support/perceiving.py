"""A perception that runs, a robot and a camera that tell it what a test wants, an operator."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from support.waiting import wait_until
from w2c import topics
from w2c.bus.inprocess import InProcessBus, InProcessHub
from w2c.clock import RealClock
from w2c.depth import encode_depth
from w2c.messages import Array, CameraFrame, CameraView, RobotState
from w2c_perception.config import PerceptionConfig
from w2c_perception.node import PerceptionNode
from w2c_sim_robot import talos
from w2c_sim_robot.description import make_description

TICK_NS = 2_000_000
DESCRIPTION = make_description()
READY = talos.ready_position()
SIZE = (128, 72)
FOCAL = 94.0

BOTH_FEET = (450.0, 450.0)


def state(tick: int, position: Array, forces: tuple[float, float] = BOTH_FEET) -> RobotState:
    """Return a state of the robot with these joint angles and forces under its feet [N]."""
    n = len(position)
    return RobotState(
        stamp_ns=tick * TICK_NS,
        tick=tick,
        position=position,
        velocity=np.zeros(n),
        torque=np.zeros(n),
        sole_wrenches=np.array([[0, 0, force, 0, 0, 0] for force in forces]),
        left_wrist_wrench=np.zeros(6),
        imu_orientation=np.array([0, 0, 0, 1.0]),
        imu_angular_velocity=np.zeros(3),
        imu_linear_acceleration=np.array([0, 0, 9.81]),
        command=position,
        command_tick=-1,
        mode="tracking",
    )


def frame(stamp_ns: int, depth: bytes | None = None) -> CameraFrame:
    """Return a picture of a wall one metre ahead of the camera."""
    wall = encode_depth(np.full((SIZE[1], SIZE[0]), 1.0, np.float32))
    return CameraFrame(
        stamp_ns=stamp_ns,
        frame=talos.CAMERA_FRAME,
        width=SIZE[0],
        height=SIZE[1],
        intrinsics=(FOCAL, FOCAL, SIZE[0] / 2, SIZE[1] / 2),
        jpeg=b"",
        depth=wall if depth is None else depth,
    )


@dataclass
class Rig:
    """A running node, and the buses of those who talk to it."""

    node: PerceptionNode
    hub: InProcessHub
    perception: InProcessBus
    robot: InProcessBus
    camera: InProcessBus
    operator: InProcessBus

    def see(
        self,
        tick: int,
        picture: CameraFrame,
        position: Array = READY,
        forces: tuple[float, float] = BOTH_FEET,
    ) -> CameraView:
        """Send states around a tick and a picture; return once perception has placed it."""
        views = self.operator.queue(topics.CAMERA_VIEW)
        done = threading.Event()
        self.tell_until_described(tick - 10, position, forces)

        def stream() -> None:
            number = tick - 9
            while not done.is_set():
                self.robot.publish(topics.ROBOT_STATE, state(number, position, forces))
                number += 1
                done.wait(0.002)

        thread = threading.Thread(target=stream)
        thread.start()
        self.camera.publish(topics.CAMERA_FRAME, picture)
        received = views.receive(20.0)
        done.set()
        thread.join()
        assert received is not None
        view: CameraView = received.message
        assert view.stamp_ns == picture.stamp_ns
        return view

    def tell_until_described(
        self, tick: int, position: Array = READY, forces: tuple[float, float] = BOTH_FEET
    ) -> None:
        """Send a state until the robot is described, and that state is taken."""
        first = state(tick, position, forces)

        def known() -> bool:
            self.robot.publish(topics.ROBOT_STATE, first)
            track = self.node._track
            return track is not None and track.newest_ns == first.stamp_ns

        wait_until(known)

    def tell(self, ticks: range, forces: tuple[float, float]) -> None:
        """Send states one by one, each once perception has had time to take the former."""
        pause = threading.Event()
        for tick in ticks:
            self.robot.publish(topics.ROBOT_STATE, state(tick, READY, forces))
            pause.wait(0.01)


@contextmanager
def perceiving() -> Iterator[Rig]:
    """Run perception of a robot that stands there."""
    hub = InProcessHub()
    bus, robot = hub.connect("perception"), hub.connect("robot")
    robot.serve(topics.DESCRIBE, lambda _request, _context: DESCRIPTION)
    node = PerceptionNode(PerceptionConfig(robot="test"), bus, RealClock())
    node.configure()
    stop = threading.Event()
    thread = threading.Thread(target=node.run, args=(stop,))
    thread.start()
    try:
        yield Rig(node, hub, bus, robot, hub.connect("camera"), hub.connect("operator"))
    finally:
        stop.set()
        thread.join(10.0)
        node.close()
    assert not thread.is_alive()
