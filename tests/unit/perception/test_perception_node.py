"""Perception on the bus: frames are placed in the world, pixels are lifted, wrong ones refused."""

import threading

import cv2
import msgspec
import numpy as np
import pytest

from support.perceiving import (
    BOTH_FEET,
    DESCRIPTION,
    READY,
    SIZE,
    TICK_NS,
    Rig,
    frame,
    state,
)
from support.waiting import wait_until
from w2c import topics
from w2c.bus.inprocess import InProcessHub
from w2c.clock import RealClock
from w2c.depth import encode_depth
from w2c.errors import RefusedError
from w2c.messages import (
    AllowedAreaRequest,
    HeightFieldRequest,
    LiftRequest,
    PointCloudRequest,
)
from w2c_perception.config import PerceptionConfig
from w2c_perception.kinematics import CameraKinematics
from w2c_perception.node import PerceptionNode


def test_a_pixel_is_lifted_into_the_world(rig: Rig) -> None:
    rig.see(1000, frame(1000 * TICK_NS))

    reply = rig.operator.call(
        topics.LIFT, LiftRequest(u=64.0, v=36.0, frame_stamp_ns=1000 * TICK_NS)
    ).message

    world_from_camera = CameraKinematics(DESCRIPTION).camera_pose(READY).world_from_camera
    assert reply.point == pytest.approx((world_from_camera @ [0, 0, 1, 1])[:3], abs=3e-4)
    assert reply.normal == pytest.approx(-world_from_camera[:3, 2], abs=1e-3)
    assert reply.frame_stamp_ns == 1000 * TICK_NS
    assert [verdict.check for verdict in reply.verdicts] == [
        "known",
        "flat",
        "large",
        "edge",
        "slope",
    ]


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


class Robot(threading.Event):
    """Where the node waits, a robot sends three states; once also a picture."""

    def __init__(self, hub: InProcessHub) -> None:
        super().__init__()
        self._bus = hub.connect("robot")
        self._camera = hub.connect("camera")
        self._bus.serve(topics.DESCRIBE, lambda _request, _context: DESCRIPTION)
        self.tick = 0

    def wait(self, timeout: float | None = None) -> bool:
        for _ in range(3):
            self.tick += 1
            self._bus.publish(topics.ROBOT_STATE, state(self.tick, READY))
        if self.tick == 30:
            self._camera.publish(topics.CAMERA_FRAME, frame(29 * TICK_NS))
        if self.tick > 60:
            self.set()
        return self.is_set()


def test_states_are_taken_at_their_rate_also_while_no_picture_waits() -> None:
    hub = InProcessHub()
    node = PerceptionNode(PerceptionConfig(robot="test"), hub.connect("perception"), RealClock())
    views = hub.connect("operator").queue(topics.CAMERA_VIEW)
    robot = Robot(hub)
    node.configure()
    robot.wait()
    thread = threading.Thread(target=node.run, args=(robot,))
    thread.start()
    view = views.receive(10.0)
    robot.set()  # for a node that never waits
    thread.join(10.0)
    assert view is not None
    assert view.message.state_ticks == list(range(3, 31, 3))


def test_with_one_foot_in_the_air_the_world_stays_where_it_was(rig: Rig) -> None:
    """The left leg is pulled up: midway between the soles is elsewhere now, the world is not."""
    before = rig.see(1000, frame(1000 * TICK_NS))
    lifted = READY.copy()
    lifted[:6] += [0.0, 0.1, -0.3, 0.6, -0.3, 0.0]  # the left leg's joints come first

    after = rig.see(2000, frame(2000 * TICK_NS), lifted, (0.0, 900.0))
    naive = CameraKinematics(DESCRIPTION).camera_pose(lifted).world_from_camera

    assert after.world_from_camera == pytest.approx(before.world_from_camera, abs=1e-6)
    assert np.abs(naive - before.world_from_camera).max() > 0.02


def test_a_robot_that_hangs_sees_nothing_until_it_stands_again(rig: Rig) -> None:
    rig.see(1000, frame(1000 * TICK_NS))
    rig.tell(range(2000, 2200, 5), (0.0, 0.0))
    rig.camera.publish(topics.CAMERA_FRAME, frame(2190 * TICK_NS))
    wait_until(lambda: rig.perception.counters.get("picture without joint angles") == 1)

    rig.tell(range(2900, 2990, 5), BOTH_FEET)
    rig.see(3000, frame(3000 * TICK_NS))

    # What was seen before it was lifted has no place in the new world.
    with pytest.raises(RefusedError, match="there are 1 from 6000000000"):
        rig.operator.call(topics.LIFT, LiftRequest(u=1.0, v=1.0, frame_stamp_ns=1000 * TICK_NS))


def test_a_pixel_of_a_picture_before_the_robot_started_anew_is_refused(rig: Rig) -> None:
    """The stamp alone would be found: time begins at zero again."""
    old = rig.see(1000, frame(1000 * TICK_NS))
    rig.robot.boot_id = "another-boot"
    new = rig.see(1000, frame(1000 * TICK_NS))
    request = LiftRequest(
        u=64.0, v=36.0, frame_stamp_ns=1000 * TICK_NS, robot_boot_id=old.robot_boot_id
    )

    assert new.robot_boot_id == "another-boot" != old.robot_boot_id
    with pytest.raises(RefusedError, match="the robot started anew"):
        rig.operator.call(topics.LIFT, request)
    rig.operator.call(topics.LIFT, msgspec.structs.replace(request, robot_boot_id="another-boot"))
    stamp_ns, boot_id = 1000 * TICK_NS, old.robot_boot_id
    heights = HeightFieldRequest(frame_stamp_ns=stamp_ns, robot_boot_id=boot_id)
    with pytest.raises(RefusedError, match="the robot started anew"):
        rig.operator.call(topics.HEIGHT_FIELD, heights)
    allowed = AllowedAreaRequest(frame_stamp_ns=stamp_ns, robot_boot_id=boot_id)
    with pytest.raises(RefusedError, match="the robot started anew"):
        rig.operator.call(topics.FIND_ALLOWED_AREA, allowed)


@pytest.mark.parametrize(
    "change",
    [
        {"frame": "camera_of_another_robot"},
        {"robot_boot_id": "that of a robot that is no more"},
        {"intrinsics": (0.0, 94.0, 64.0, 36.0)},
        {"intrinsics": (float("nan"), 94.0, 64.0, 36.0)},
        {"depth_unit": 0.0},
        {"depth_unit": float("inf")},
    ],
)
def test_a_picture_of_another_camera_is_refused_and_counted(
    rig: Rig, change: dict[str, object]
) -> None:
    rig.see(1000, frame(1000 * TICK_NS))

    strange = msgspec.structs.replace(frame(1001 * TICK_NS), **change)
    rig.camera.publish(topics.CAMERA_FRAME, strange)

    wait_until(lambda: rig.perception.counters.get("picture refused") == 1)


def test_a_state_without_numbers_is_dropped_and_counted(rig: Rig) -> None:
    rig.see(1000, frame(1000 * TICK_NS))

    broken = READY.copy()
    broken[3] = np.nan
    rig.robot.publish(topics.ROBOT_STATE, state(1200, broken))

    wait_until(lambda: rig.perception.counters.get("state without joint angles") == 1)


@pytest.mark.parametrize("pixel", [(-1.0, 0.0), (128.0, 0.0), (float("nan"), 0.0), (0.0, 1e30)])
def test_a_pixel_that_is_not_in_the_picture_is_refused(
    rig: Rig, pixel: tuple[float, float]
) -> None:
    rig.see(1000, frame(1000 * TICK_NS))

    request = LiftRequest(u=pixel[0], v=pixel[1], frame_stamp_ns=1000 * TICK_NS)
    with pytest.raises(RefusedError, match="outside of the picture, 128x72"):
        rig.operator.call(topics.LIFT, request)


@pytest.mark.parametrize("shape", [(72, 64), (144, 128)])
def test_depth_of_another_size_is_refused(rig: Rig, shape: tuple[int, int]) -> None:
    other = encode_depth(np.full(shape, 1.0, np.float32))
    rig.see(1000, frame(1000 * TICK_NS, depth=other))

    with pytest.raises(RefusedError, match="no usable depth"):
        rig.operator.call(topics.LIFT, LiftRequest(u=9.0, v=9.0, frame_stamp_ns=1000 * TICK_NS))


def test_the_bound_holds_what_biased_joints_would_do(rig: Rig) -> None:
    rig.see(1000, frame(1000 * TICK_NS))

    reply = rig.operator.call(
        topics.LIFT, LiftRequest(u=64.0, v=36.0, frame_stamp_ns=1000 * TICK_NS)
    ).message

    pose = CameraKinematics(DESCRIPTION).camera_pose(READY)
    of_joints = pose.error(reply.point, PerceptionConfig(robot="test").joint_error)
    assert 0.001 < of_joints < reply.error_bound < of_joints + 0.002


def test_points_come_with_colours_and_without_a_picture_they_are_refused(rig: Rig) -> None:
    picture = np.full((SIZE[1], SIZE[0], 3), (0, 0, 250), np.uint8)
    jpeg = cv2.imencode(".jpg", picture)[1].tobytes()
    rig.see(1000, msgspec.structs.replace(frame(1000 * TICK_NS), jpeg=jpeg))
    rig.see(1100, frame(1100 * TICK_NS))

    cloud = rig.operator.call(
        topics.POINT_CLOUD, PointCloudRequest(frame_stamp_ns=1000 * TICK_NS, voxel=0.02)
    ).message

    world_from_camera = CameraKinematics(DESCRIPTION).camera_pose(READY).world_from_camera
    in_camera = (cloud.points - world_from_camera[:3, 3]) @ world_from_camera[:3, :3]
    assert len(cloud.points) > 200
    assert in_camera[:, 2] == pytest.approx(np.ones(len(cloud.points)), abs=1e-3)
    assert cloud.colours[:, 0].min() > 240
    with pytest.raises(RefusedError, match="no usable colours"):
        rig.operator.call(topics.POINT_CLOUD, PointCloudRequest(frame_stamp_ns=1100 * TICK_NS))


def test_where_a_hand_may_go_is_told_with_reasons(rig: Rig) -> None:
    rig.see(1000, frame(1000 * TICK_NS))

    area = rig.operator.call(
        topics.FIND_ALLOWED_AREA, AllowedAreaRequest(frame_stamp_ns=1000 * TICK_NS)
    ).message

    assert (area.width, area.height) == SIZE
    assert "too steep" in area.reasons
    # The picture shows a plane square to the camera, which looks down steeply: too steep.
    assert area.reasons[int(area.cells[4, 8]) - 1] == "too steep"
