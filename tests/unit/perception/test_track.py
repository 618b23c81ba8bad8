"""Pictures are placed by the joint angles of their instants: of the colours, and of depth."""

import msgspec
import numpy as np
import pytest

from support.perceiving import DESCRIPTION, READY, TICK_NS, frame, state
from w2c.errors import GeometryError, RefusedError
from w2c.geometry import apply
from w2c.messages import Array, HeightFieldRequest, LiftRequest
from w2c_perception.answers import Answers
from w2c_perception.config import PerceptionConfig
from w2c_perception.kinematics import CameraKinematics
from w2c_perception.memory import PictureMemory
from w2c_perception.track import RobotTrack

HEAD = [joint.name for joint in DESCRIPTION.joints].index("head_1_joint")
AT = 1000


def nodding(tick: int) -> Array:
    """Return the joint angles of a robot whose head turns by 0.5 rad/s."""
    position = READY.copy()
    position[HEAD] += 0.5 * 0.002 * (tick - AT)
    return position


@pytest.fixture
def track() -> RobotTrack:
    track = RobotTrack(DESCRIPTION, "boot", 60.0)
    for tick in range(AT - 200, AT + 10, 5):
        track.add(state(tick, nodding(tick)))
    return track


def test_depth_is_placed_by_where_the_camera_was_then(track: RobotTrack) -> None:
    """A wall one metre before the camera then, whatever the head did until the colours."""
    kinematics = CameraKinematics(DESCRIPTION)
    early = AT - 25  # 50 ms, 1.4 degrees
    picture = msgspec.structs.replace(frame(AT * TICK_NS), depth_stamp_ns=early * TICK_NS)
    memory = PictureMemory(60.0, 10, 2)
    memory.add(track.place(picture))
    answers = Answers(PerceptionConfig(robot="test"), memory)
    request = LiftRequest(u=64.0, v=36.0, frame_stamp_ns=AT * TICK_NS)

    reply = answers.lift(request, None)

    then = kinematics.camera_pose(nodding(early)).world_from_camera
    normal = -then[:3, 2]
    assert reply.normal == pytest.approx(normal, abs=2e-3)
    assert (reply.point - apply(then, [0, 0, 1.0])) @ normal == pytest.approx(0.0, abs=5e-4)
    # It is on the ray of the pixel, from where the camera was when it took the colours.
    now = kinematics.camera_pose(nodding(AT)).world_from_camera
    along = now[:3, 2]
    aside = (reply.point - now[:3, 3]) - ((reply.point - now[:3, 3]) @ along) * along
    assert np.linalg.norm(aside) < 5e-4
    assert np.linalg.norm(reply.point - apply(now, [0, 0, 1.0])) > 1e-4
    of_depth = answers.heights(
        HeightFieldRequest(frame_stamp_ns=AT * TICK_NS),
        None,
    ).heights
    memory.add(track.place(frame(early * TICK_NS)))  # the same depth, with the colours
    expected = answers.heights(
        HeightFieldRequest(frame_stamp_ns=early * TICK_NS),
        None,
    ).heights
    assert np.array_equal(of_depth, expected, equal_nan=True)


def test_what_is_not_known_of_the_angles_of_both_instants_widens_the_bound(
    track: RobotTrack,
) -> None:
    apart = msgspec.structs.replace(frame(AT * TICK_NS), depth_stamp_ns=(AT - 25) * TICK_NS)
    exact = track.place(apart)
    between = track.place(
        msgspec.structs.replace(apart, depth_stamp_ns=(AT - 25) * TICK_NS + 3_000_000)
    )
    depth = np.ones((72, 128), np.float32)

    assert exact.blur(depth, 64.0, 36.0, 0.0) == pytest.approx(0.0, abs=1e-9)
    jerked = RobotTrack(DESCRIPTION, "boot", 60.0)
    for tick in range(AT - 200, AT + 10, 5):
        jerked.add(state(tick, nodding(tick) + (0.002 if tick == AT - 25 else 0.0)))
    uncertain = jerked.place(between.frame)
    assert uncertain.blur(depth, 64.0, 36.0, 0.0) > 0.01
    point = np.array([1.0, 0.0, 1.0])
    assert uncertain.pose_error(point, 0.0) > between.pose_error(point, 0.0)


@pytest.mark.parametrize(
    ("depth_tick", "error", "reason"),
    [
        (AT - 160, GeometryError, r"0\.32 s apart from the colours, limit 0\.3 s"),
        (AT + 20, RefusedError, "outside"),
    ],
)
def test_depth_of_another_time_altogether_is_refused(
    track: RobotTrack, depth_tick: int, error: type[Exception], reason: str
) -> None:
    picture = msgspec.structs.replace(frame(AT * TICK_NS), depth_stamp_ns=depth_tick * TICK_NS)
    with pytest.raises(error, match=reason):
        track.place(picture)
