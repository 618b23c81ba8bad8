"""The camera on the bus: it draws what the robot reports, at its rate, and on demand."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from support.pictures import decoded
from support.waiting import wait_until
from w2c import topics
from w2c.bus.inprocess import InProcessBus, InProcessHub
from w2c.clock import RealClock
from w2c.depth import decode_depth
from w2c.errors import ConfigError, RefusedError, W2CError
from w2c.messages import Array, CaptureRequest, PictureRequest, Truth
from w2c_sim_robot.camera.config import CameraConfig
from w2c_sim_robot.camera.node import CameraNode
from w2c_sim_robot.model import build_model, ready_configuration
from w2c_sim_robot.scenes.scenario_a import scenario_a
from w2c_sim_robot.scenes.scene import save


def truth(stamp_ns: int, position: Array) -> Truth:
    """Return what the simulator reports."""
    return Truth(
        stamp_ns=stamp_ns,
        tick=stamp_ns // 2_000_000,
        generalized_position=position,
        world_from_base=np.array([0, 0, 1, 0, 0, 0, 1.0]),
        end_effector_positions=np.zeros((4, 3)),
        contact_forces=np.zeros((4, 3)),
        fell=False,
    )


@dataclass
class Rig:
    """A camera that runs, and the buses of those who talk to it."""

    camera: InProcessBus
    robot: InProcessBus
    operator: InProcessBus
    scene: str
    """Its file"""
    position: Array
    """(nq,) of the robot standing ready in the camera's scene"""


@contextmanager
def running(config: CameraConfig, bus: InProcessBus) -> Iterator[None]:
    """Run a camera; its loop, like OpenGL, lives on one thread."""
    stop, ready = threading.Event(), threading.Event()

    def live() -> None:
        node = CameraNode(config, bus, RealClock())
        try:
            node.configure()
            ready.set()
            node.run(stop)
        finally:
            node.close()

    thread = threading.Thread(target=live)
    thread.start()
    try:
        assert ready.wait(60.0)
        yield
    finally:
        stop.set()
        thread.join(20.0)
    assert not thread.is_alive()


@pytest.fixture(scope="module")
def rig(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Rig]:
    """Yield a running camera of scenario (a)."""
    path = tmp_path_factory.mktemp("scene") / "scene.json"
    scene = scenario_a()
    save(scene, path)
    hub = InProcessHub()
    bus = hub.connect("camera")
    with running(CameraConfig(robot="test", scene=str(path), rate=30.0), bus):
        position = ready_configuration(build_model(scene))
        yield Rig(bus, hub.connect("robot"), hub.connect("operator"), str(path), position)


def test_before_the_robot_speaks_a_capture_is_refused_with_the_reason() -> None:
    hub = InProcessHub()

    with (
        running(CameraConfig(robot="test"), hub.connect("camera")),
        pytest.raises(RefusedError, match="start `w2c robot`"),
    ):
        hub.connect("operator").call(topics.CAPTURE, CaptureRequest())


def test_a_frame_carries_the_stamp_of_the_truth_it_drew(rig: Rig) -> None:
    frames = rig.operator.queue(topics.CAMERA_FRAME)
    sent = rig.robot.publish(topics.TRUTH, truth(4_000_000, rig.position))

    received = frames.receive(20.0)

    assert received is not None
    assert received.message.stamp_ns == 4_000_000
    assert received.message.robot_boot_id == rig.robot.boot_id
    assert (received.message.width, received.message.height) == (1280, 720)
    assert received.message.frame == "rgbd_rgb_optical_frame"
    assert [made_of.sequence for made_of in received.envelope.inputs] == [sent.sequence]
    image = decoded(received.message.jpeg)
    assert image.shape == (720, 1280, 3)
    # The same truth is not drawn twice.
    assert frames.receive(0.1) is None


def test_a_capture_is_drawn_on_demand_and_goes_on_the_stream(rig: Rig) -> None:
    frames = rig.operator.queue(topics.CAMERA_FRAME)
    rig.robot.publish(topics.TRUTH, truth(6_000_000, rig.position))
    assert frames.receive(20.0) is not None

    captured = rig.operator.call(topics.CAPTURE, CaptureRequest(shadows=True)).message

    assert captured.stamp_ns == 6_000_000
    assert captured.robot_boot_id == rig.robot.boot_id
    streamed = frames.receive(5.0)
    assert streamed is not None
    assert streamed.message.jpeg == captured.jpeg


def test_a_picture_from_outside_has_the_size_that_was_asked_for(rig: Rig) -> None:
    rig.robot.publish(topics.TRUTH, truth(8_000_000, rig.position))

    picture = rig.operator.call(
        topics.PICTURE, PictureRequest(view="side", width=160, height=120)
    ).message

    assert decoded(picture.jpeg).shape == (120, 160, 3)


def test_a_robot_with_another_scene_is_counted_not_drawn(rig: Rig) -> None:
    frames = rig.operator.queue(topics.CAMERA_FRAME)
    before = rig.camera.counters.get("truth of another model", 0)

    rig.robot.publish(topics.TRUTH, truth(10_000_000, np.zeros(3)))
    wait_until(lambda: rig.camera.counters.get("truth of another model", 0) > before)

    assert frames.receive(0.05) is None
    with pytest.raises(RefusedError, match="same --scene"):
        rig.operator.call(topics.CAPTURE, CaptureRequest())
    rig.robot.publish(topics.TRUTH, truth(12_000_000, rig.position))
    assert frames.receive(20.0) is not None


def test_a_camera_of_rate_0_draws_only_when_asked_in_the_size_it_was_given(rig: Rig) -> None:
    hub = InProcessHub()
    robot, operator = hub.connect("robot"), hub.connect("operator")
    frames = operator.queue(topics.CAMERA_FRAME)
    config = CameraConfig(
        robot="test", scene=rig.scene, rate=0.0, width=320, height=180, jpeg_quality=60
    )
    with running(config, hub.connect("camera")):
        robot.publish(topics.TRUTH, truth(4_000_000, rig.position))
        assert frames.receive(0.3) is None

        captured = operator.call(topics.CAPTURE, CaptureRequest()).message

    assert decoded(captured.jpeg).shape == (180, 320, 3)
    assert (captured.width, captured.height) == (320, 180)
    assert captured.intrinsics[2:] == (160.0, 90.0)


@pytest.mark.parametrize(
    ("flags", "complaint"),
    [
        (["--width", "0", "--height", "0"], "width"),
        (["--rate", "-1"], "rate"),
        (["--jpeg-quality", "101"], "jpeg"),
    ],
)
def test_a_camera_of_0x0_is_refused_before_anything_starts(
    flags: list[str], complaint: str, capsys: pytest.CaptureFixture[str]
) -> None:
    from w2c_sim_robot.camera.__main__ import main

    try:
        status = main(["--robot", "test", *flags])
    except SystemExit as stopped:
        status = int(str(stopped.code))
    assert status == 2
    assert complaint in capsys.readouterr().err


def test_depth_may_be_of_before_its_colours_and_says_so(rig: Rig) -> None:
    hub = InProcessHub()
    robot, operator = hub.connect("robot"), hub.connect("operator")
    config = CameraConfig(
        robot="test", scene=rig.scene, rate=30.0, width=128, height=72, depth_delay=0.05
    )
    nodded = rig.position.copy()
    nodded[build_model(scenario_a()).joint("head_1_joint").qposadr[0]] += 0.2
    with running(config, hub.connect("camera")):
        frames = operator.queue(topics.CAMERA_FRAME)
        robot.publish(topics.TRUTH, truth(4_000_000, rig.position))
        wait_until(lambda: not frames.receive(0.05) and not robot.counters)
        for stamp_ns in (30_000_000, 54_000_000):
            robot.publish(topics.TRUTH, truth(stamp_ns, nodded))
            threading.Event().wait(0.02)
        late = frames.receive(20.0)
        robot.publish(topics.TRUTH, truth(60_000_000, nodded))
        robot_moved_on = truth(120_000_000, nodded)
        wait_until(lambda: bool(robot.publish(topics.TRUTH, robot_moved_on)))
        still = frames.receive(20.0)

    assert late is not None and still is not None
    assert (late.message.depth_stamp_ns, late.message.stamp_ns) == (4_000_000, 54_000_000)
    assert len(late.envelope.inputs) == 2
    depths = [decode_depth(one.message.depth, 128, 72) for one in (late, still)]
    colours = [decoded(one.message.jpeg).astype(float) for one in (late, still)]
    assert np.abs(depths[0] - depths[1]).mean() > 0.02, "depth is of before the nod"
    assert np.abs(colours[0] - colours[1]).mean() < 1.0, "the colours are of after it"


def test_a_picture_of_0x0_is_refused_with_the_limit(rig: Rig) -> None:
    with pytest.raises(W2CError, match=r"(?i)width|16"):
        rig.operator.call(topics.PICTURE, PictureRequest(view="side", width=0, height=0))


def test_a_missing_scene_file_stops_the_camera_before_it_starts(tmp_path: Path) -> None:
    bus = InProcessHub().connect("camera")
    config = CameraConfig(robot="test", scene=str(tmp_path / "gone.json"))

    with pytest.raises(ConfigError, match="no scene file"):
        CameraNode(config, bus, RealClock()).configure()
