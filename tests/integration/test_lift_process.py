"""Robot, camera and perception as processes of their own: a pixel becomes a point of the world."""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import msgspec
import numpy as np
import pytest

from support.ports import free_endpoint
from support.waiting import wait_until
from w2c import topics
from w2c.bus import Bus
from w2c.bus.zenoh_bus import connect
from w2c.config import ServiceConfig
from w2c.errors import RefusedError
from w2c.geometry import Intrinsics, inverse
from w2c.messages import CameraView, LiftRequest
from w2c_perception.commands import cloud
from w2c_sim_robot.scenes.scenario_a import scenario_a
from w2c_sim_robot.scenes.scene import save

pytestmark = pytest.mark.real_time


@contextmanager
def process(*command: str) -> Iterator[None]:
    """Run a module of the project; it must end well at SIGTERM."""
    running = subprocess.Popen([sys.executable, "-m", *command])
    try:
        yield
        running.terminate()
        assert running.wait(20.0) == 0
    finally:
        running.kill()
        running.wait()


@contextmanager
def system(directory: Path) -> Iterator[tuple[Bus, list[str]]]:
    """Yield an operator's bus, and the flags of one, to a standing robot that sees scenario (a)."""
    config = ServiceConfig(robot="sees", router=free_endpoint(), robot_endpoint=free_endpoint())
    scene = directory / "scene.json"
    save(scenario_a(), scene)
    flags = [
        *("--robot", config.robot),
        *("--router", config.router, "--robot-endpoint", config.robot_endpoint),
    ]
    with ExitStack() as stack:
        stack.enter_context(process("w2c.cli", "router", "--listen", config.router))
        stack.enter_context(process("w2c_sim_robot", *flags, "--scene", str(scene)))
        stack.enter_context(process("w2c_sim_robot.camera", *flags, "--scene", str(scene)))
        stack.enter_context(process("w2c_perception", *flags))
        bus = stack.enter_context(connect(config, "operator", [config.router]))
        yield bus, ["--robot", config.robot, "--router", config.router]


def test_the_middle_of_the_book_is_found_where_the_scene_has_it(tmp_path: Path) -> None:
    with system(tmp_path) as (bus, flags):
        views = bus.latest(topics.CAMERA_VIEW)
        wait_until(lambda: views.last() is not None, timeout_s=90.0)
        received = views.last()
        assert received is not None
        view: CameraView = received.message
        book = np.array(scenario_a().object("book").top_in_world)
        in_camera = inverse(view.world_from_camera) @ [*book, 1.0]
        u, v = Intrinsics(*view.intrinsics).pixel_from_point(in_camera[:3])

        request = LiftRequest(u=u, v=v, frame_stamp_ns=view.stamp_ns)
        reply = bus.call(topics.LIFT, request, timeout_s=20.0).message

        # The robot has sagged a little under its weight: its own angles tell the camera so.
        error = float(np.linalg.norm(reply.point - book))
        assert error < min(0.002, reply.error_bound)
        # The book is 19 x 26 cm.
        assert 0.07 <= reply.edge_distance <= 0.11
        assert reply.normal[2] > 0.999
        with pytest.raises(RefusedError, match="no picture of stamp 1 ns"):
            bus.call(topics.LIFT, LiftRequest(u=u, v=v, frame_stamp_ns=1), timeout_s=20.0)
        other = msgspec.structs.replace(request, robot_boot_id="another")
        with pytest.raises(RefusedError, match="the robot started anew"):
            bus.call(topics.LIFT, other, timeout_s=20.0)
        assert view.robot_boot_id

        file = tmp_path / "book.ply"
        low, high = (str(x) for x in book - 0.03), (str(x) for x in book + 0.03)
        assert cloud([str(file), *flags, "--low", *low, "--high", *high]) == 0
        header = file.read_bytes().partition(b"end_header")[0].decode("ascii")
        points = int(header.split("element vertex ")[1].split()[0])
        assert 50 < points < 300  # 6 x 6 cm, a point every 5 mm


@pytest.mark.parametrize("module", ["w2c_sim_robot.camera", "w2c_perception"])
def test_bad_flags_end_with_status_2(module: str) -> None:
    command = [sys.executable, "-m", module, "--robot", "x", "--no-such-flag", "1"]

    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)

    assert done.returncode == 2
    assert "no-such-flag" in done.stderr + done.stdout


def test_a_camera_without_opengl_says_what_to_install() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "w2c_sim_robot.camera", "--robot", "x"],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        env={"MUJOCO_GL": "none-such", "PATH": "/usr/bin:/bin"},
    )

    assert done.returncode == 2
    assert "apt-get install" in done.stderr
