"""Perception on the bus: frames are placed in the world, pixels are lifted, wrong ones refused."""

import threading
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest

from support.waiting import wait_until
from w2c import topics
from w2c.bus.inprocess import InProcessBus, InProcessHub
from w2c.clock import RealClock
from w2c.depth import encode_depth
from w2c.errors import RefusedError
from w2c.messages import Array, CameraFrame, HeightFieldRequest, LiftRequest, RobotState
from w2c_perception.config import PerceptionConfig
from w2c_perception.kinematics import CameraKinematics
from w2c_perception.node import PerceptionNode
from w2c_sim_robot import talos
from w2c_sim_robot.description import make_description

TICK_NS = 2_000_000
DESCRIPTION = make_description()
READY = talos.ready_position()
SIZE = (128, 72)
FOCAL = 94.0


def state(tick: int, position: Array) -> RobotState:
    """Return a state of the robot with these joint angles."""
    n = len(position)
    return RobotState(
        stamp_ns=tick * TICK_NS,
        tick=tick,
        position=position,
        velocity=np.zeros(n),
        torque=np.zeros(n),
        sole_wrenches=np.tile([0, 0, 450.0, 0, 0, 0], (2, 1)),
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

    perception: InProcessBus
    robot: InProcessBus
    camera: InProcessBus
    operator: InProcessBus

    def see(self, tick: int, picture: CameraFrame) -> None:
        """Send states around a tick and a picture; return once perception has placed it."""
        views = self.operator.queue(topics.CAMERA_VIEW)
        done = threading.Event()

        def stream() -> None:
            number = tick - 10
            while not done.is_set():
                self.robot.publish(topics.ROBOT_STATE, state(number, READY))
                number += 1
                done.wait(0.002)

        thread = threading.Thread(target=stream)
        thread.start()
        self.camera.publish(topics.CAMERA_FRAME, picture)
        received = views.receive(20.0)
        done.set()
        thread.join()
        assert received is not None
        assert received.message.stamp_ns == picture.stamp_ns


@pytest.fixture
def rig() -> Iterator[Rig]:
    hub = InProcessHub()
    bus, robot = hub.connect("perception"), hub.connect("robot")
    robot.serve(topics.DESCRIBE, lambda _request, _context: DESCRIPTION)
    node = PerceptionNode(PerceptionConfig(robot="test"), bus, RealClock())
    node.configure()
    stop = threading.Event()
    thread = threading.Thread(target=node.run, args=(stop,))
    thread.start()
    yield Rig(bus, robot, hub.connect("camera"), hub.connect("operator"))
    stop.set()
    thread.join(10.0)
    node.close()
    assert not thread.is_alive()


def test_a_pixel_is_lifted_into_the_world(rig: Rig) -> None:
    rig.see(1000, frame(1000 * TICK_NS))

    reply = rig.operator.call(
        topics.LIFT, LiftRequest(u=64.0, v=36.0, frame_stamp_ns=1000 * TICK_NS)
    ).message

    world_from_camera = CameraKinematics(DESCRIPTION).camera_pose(READY).world_from_camera
    assert reply.point == pytest.approx((world_from_camera @ [0, 0, 1, 1])[:3], abs=3e-4)
    assert reply.normal == pytest.approx(-world_from_camera[:3, 2], abs=1e-3)
    assert reply.frame_stamp_ns == 1000 * TICK_NS


def test_each_picture_is_told_where_it_was_taken_and_from_what(rig: Rig) -> None:
    views = rig.operator.queue(topics.CAMERA_VIEW)

    rig.see(500, frame(500 * TICK_NS))

    received = views.receive(1.0)
    assert received is not None
    assert received.message.world_from_camera == pytest.approx(
        CameraKinematics(DESCRIPTION).camera_pose(READY).world_from_camera, abs=1e-9
    )
    assert [made_of.key.split("/")[-2:] for made_of in received.envelope.inputs] == [
        ["camera", "rgbd"]
    ]


def test_heights_are_those_of_the_picture_without_the_arms(rig: Rig) -> None:
    rig.see(1000, frame(1000 * TICK_NS))

    request = HeightFieldRequest(frame_stamp_ns=1000 * TICK_NS)
    field = rig.operator.call(topics.HEIGHT_FIELD, request).message

    assert field.stamp_ns == 1000 * TICK_NS
    world_from_camera = CameraKinematics(DESCRIPTION).camera_pose(READY).world_from_camera
    x, y, height = (world_from_camera @ [0, 0, 1, 1])[:3]
    row = int((x - field.origin[0]) / field.cell)
    column = int((y - field.origin[1]) / field.cell)
    assert field.heights[row, column] == pytest.approx(height, abs=0.02)
    assert np.isnan(field.heights).any()
    with pytest.raises(RefusedError, match="newest"):
        rig.operator.call(topics.HEIGHT_FIELD, HeightFieldRequest(frame_stamp_ns=9 * 10**9))


def test_a_stamp_that_is_not_remembered_is_refused_with_what_is(rig: Rig) -> None:
    rig.see(1000, frame(1000 * TICK_NS))

    with pytest.raises(RefusedError, match=r"newest; there are 1 from 2000000000"):
        rig.operator.call(topics.LIFT, LiftRequest(u=1.0, v=1.0, frame_stamp_ns=9 * 10**9))


def test_the_sky_and_a_broken_depth_are_refused_with_the_reason(rig: Rig) -> None:
    rig.see(1000, frame(1000 * TICK_NS, depth=b""))
    rig.see(1100, frame(1100 * TICK_NS, depth=b"rubbish"))

    with pytest.raises(RefusedError, match="no depth at pixel"):
        rig.operator.call(topics.LIFT, LiftRequest(u=9.0, v=9.0, frame_stamp_ns=1000 * TICK_NS))
    with pytest.raises(RefusedError, match="no usable depth"):
        rig.operator.call(topics.LIFT, LiftRequest(u=9.0, v=9.0, frame_stamp_ns=1100 * TICK_NS))


def test_a_picture_from_before_the_joint_angles_is_dropped_and_counted(rig: Rig) -> None:
    rig.see(1000, frame(1000 * TICK_NS))

    rig.camera.publish(topics.CAMERA_FRAME, frame(10))

    wait_until(lambda: rig.perception.counters.get("picture without joint angles") == 1)


def test_a_robot_that_starts_anew_is_described_anew_and_old_pictures_are_forgotten(
    rig: Rig,
) -> None:
    rig.see(1000, frame(1000 * TICK_NS))
    rig.robot.boot_id = "another-boot"

    rig.see(50, frame(50 * TICK_NS))

    with pytest.raises(RefusedError, match="newest; there are 1"):
        rig.operator.call(topics.LIFT, LiftRequest(u=1.0, v=1.0, frame_stamp_ns=1000 * TICK_NS))


def test_perception_waits_for_a_robot_that_is_not_there_yet() -> None:
    hub = InProcessHub()
    node = PerceptionNode(PerceptionConfig(robot="test"), hub.connect("perception"), RealClock())
    node.configure()
    stop = threading.Event()
    thread = threading.Thread(target=node.run, args=(stop,))
    thread.start()
    robot = hub.connect("robot")
    asked = threading.Event()

    def describe(_request: object, _context: object) -> object:
        asked.set()
        return DESCRIPTION

    robot.serve(topics.DESCRIBE, describe)  # type: ignore[arg-type]
    assert asked.wait(20.0)
    stop.set()
    thread.join(10.0)
    assert not thread.is_alive()
