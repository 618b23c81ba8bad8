"""Which picture is shown, and where the target is on it."""

import math

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fakes.table_picture import BOOK_TOP, CAMERA, HEIGHT, WIDTH, camera_pose, make_target, pixel_of
from w2c.messages import AllowedArea, CameraFrame, CameraView
from w2c_console.journal import area_news
from w2c_console.view import (
    FRAMES_KEPT,
    POSE_PATIENCE_NS,
    FrameHistory,
    compose,
    project,
)

SECOND = 1_000_000_000


def frame(stamp_ns: int) -> CameraFrame:
    return CameraFrame(
        stamp_ns=stamp_ns,
        frame="camera",
        width=WIDTH,
        height=HEIGHT,
        intrinsics=CAMERA,
        jpeg=b"jpeg",
        depth=b"",
    )


def view(stamp_ns: int, yaw: float = 0.0) -> CameraView:
    return CameraView(
        stamp_ns=stamp_ns,
        world_from_camera=camera_pose(yaw),
        intrinsics=CAMERA,
        width=WIDTH,
        height=HEIGHT,
    )


def history(*stamps: int, views: tuple[int, ...] = (), yaw: float = 0.0) -> FrameHistory:
    result = FrameHistory()
    for stamp in stamps:
        result.add_frame(frame(stamp), arrived_ns=stamp)
    for stamp in views:
        result.add_view(view(stamp, yaw))
    return result


def test_without_anything_there_is_nothing_to_show() -> None:
    scene = compose(FrameHistory(), make_target("t-1", 1), live=False)
    assert scene.frame is None
    assert scene.marker is None


def test_without_a_target_the_newest_picture_is_shown() -> None:
    scene = compose(history(SECOND, 2 * SECOND), None, live=False)
    assert scene.frame is not None
    assert scene.frame.stamp_ns == 2 * SECOND
    assert scene.marker is None


def test_on_its_own_picture_the_target_is_at_its_own_pixel_without_any_pose() -> None:
    target = make_target("t-1", SECOND)
    scene = compose(history(SECOND), target, live=False)
    assert scene.marker is not None
    assert (scene.marker.u, scene.marker.v) == (target.u, target.v)
    assert [box.phrase for box in scene.boxes] == ["book"]


def test_on_a_newer_picture_the_point_is_projected_with_the_pose_of_that_picture() -> None:
    frames = history(SECOND, 2 * SECOND, views=(2 * SECOND,), yaw=0.1)
    scene = compose(frames, make_target("t-1", SECOND), live=False)
    assert scene.frame is not None
    assert scene.frame.stamp_ns == 2 * SECOND
    assert scene.marker is not None
    expected = pixel_of(BOOK_TOP, camera_pose(0.1))
    assert (scene.marker.u, scene.marker.v) == pytest.approx(expected)
    assert scene.boxes == ()  # they are pixels of a picture in which everything was elsewhere


def test_boxes_stay_while_the_camera_stands_still() -> None:
    frames = history(SECOND, 2 * SECOND, views=(2 * SECOND,))
    scene = compose(frames, make_target("t-1", SECOND), live=False)
    assert [box.phrase for box in scene.boxes] == ["book"]


@given(yaw=st.floats(-0.2, 0.2), x=st.floats(0.4, 0.9), y=st.floats(-0.2, 0.2))
def test_projection_undoes_the_ray_through_a_pixel(yaw: float, x: float, y: float) -> None:
    """The pixel that `project` finds sees the point it was made of."""
    point = np.array([x, y, 0.75])
    target = make_target("t-1", SECOND, point=point)
    pixel = project(view(SECOND, yaw), target)
    if pixel is None:
        u, v = pixel_of(point, camera_pose(yaw))
        assert not (0 <= u < WIDTH and 0 <= v < HEIGHT)
        return
    world_from_camera = camera_pose(yaw)
    ray = world_from_camera[:3, :3] @ CAMERA.point_from_pixel(*pixel, depth=1.0)
    scale = (0.75 - world_from_camera[2, 3]) / ray[2]
    np.testing.assert_allclose(world_from_camera[:3, 3] + scale * ray, point, atol=1e-9)


@pytest.mark.parametrize("yaw", [math.pi, 1.2])
def test_a_target_behind_or_beside_the_camera_is_not_drawn_but_told(yaw: float) -> None:
    frames = history(SECOND, 2 * SECOND, views=(2 * SECOND,), yaw=yaw)
    scene = compose(frames, make_target("t-1", SECOND), live=False)
    assert scene.marker is None
    assert "outside" in scene.notice


def test_a_picture_without_pose_waits_for_it_a_little() -> None:
    """Perception answers a moment after the picture: the target must not blink meanwhile."""
    frames = history(SECOND, SECOND + POSE_PATIENCE_NS // 2, views=(SECOND,))
    scene = compose(frames, make_target("t-1", SECOND), live=False)
    assert scene.frame is not None
    assert scene.frame.stamp_ns == SECOND
    assert scene.marker is not None
    assert scene.notice == ""


def test_without_depth_the_page_freezes_on_the_picture_of_the_target_and_says_so() -> None:
    frames = history(SECOND, 2 * SECOND, 3 * SECOND, views=(SECOND, 2 * SECOND, 3 * SECOND))
    target = make_target("t-1", SECOND, point=None)
    scene = compose(frames, target, live=False)
    assert scene.frame is not None
    assert scene.frame.stamp_ns == SECOND
    assert scene.frozen
    assert scene.marker is not None
    assert (scene.marker.u, scene.marker.v) == (target.u, target.v)
    assert "frozen" in scene.notice
    assert "depth" in scene.notice


def test_without_a_camera_pose_the_page_freezes_too() -> None:
    frames = history(SECOND, 2 * SECOND + POSE_PATIENCE_NS)
    scene = compose(frames, make_target("t-1", SECOND), live=False)
    assert scene.frozen
    assert "perception" in scene.notice


def test_the_operator_can_look_at_the_live_picture_and_then_sees_no_target() -> None:
    frames = history(SECOND, 2 * SECOND)
    scene = compose(frames, make_target("t-1", SECOND, point=None), live=True)
    assert scene.frame is not None
    assert scene.frame.stamp_ns == 2 * SECOND
    assert scene.marker is None
    assert scene.notice != ""


@pytest.mark.parametrize("state", ["confirmed", "reached", "in_contact"])
def test_only_a_target_that_waits_for_a_decision_freezes_the_page(state: str) -> None:
    frames = history(SECOND, 2 * SECOND)
    scene = compose(frames, make_target("t-1", SECOND, point=None, state=state), live=False)
    assert scene.frame is not None
    assert scene.frame.stamp_ns == 2 * SECOND
    assert scene.marker is None


def test_an_abandoned_target_is_not_shown() -> None:
    scene = compose(history(SECOND), make_target("t-1", SECOND, state="abandoned"), live=False)
    assert scene.marker is None
    assert scene.notice == ""


def test_a_target_whose_picture_is_gone_is_not_drawn_on_another_one() -> None:
    scene = compose(history(2 * SECOND), make_target("t-1", SECOND, point=None), live=False)
    assert scene.marker is None
    assert "no longer kept" in scene.notice


def test_a_picture_that_was_spoken_about_outlives_the_others() -> None:
    frames = history(SECOND)
    frames.pin(SECOND)
    for index in range(2, 2 * FRAMES_KEPT):
        frames.add_frame(frame(index * SECOND), arrived_ns=index)
    assert frames.get(SECOND) is not None
    assert frames.get(2 * SECOND) is None


def test_poses_of_an_earlier_start_of_the_robot_are_forgotten() -> None:
    """Robot time begins again: a stamp then means another picture, and another pose."""
    frames = history(SECOND, 5 * SECOND, views=(SECOND, 5 * SECOND))
    frames.add_frame(frame(SECOND), arrived_ns=0)
    assert frames.view(SECOND) is None
    assert frames.newest is not None
    assert frames.newest.sequence == 3


def test_pictures_of_another_boot_of_the_robot_are_not_mixed_with_newer_stamps() -> None:
    """A camera that outlives the robot: its stamps need not go back, what they mean does."""
    past = history(1 * SECOND, views=(1 * SECOND,))
    past.add_frame(msgspec.structs.replace(frame(2 * SECOND), robot_boot_id="first"), 0)
    past.add_frame(msgspec.structs.replace(frame(3 * SECOND), robot_boot_id="second"), 0)
    assert past.get(2 * SECOND) is None
    past.add_view(msgspec.structs.replace(view(3 * SECOND), robot_boot_id="first"))
    assert past.view(3 * SECOND) is None
    past.add_view(msgspec.structs.replace(view(3 * SECOND), robot_boot_id="second"))
    assert past.view(3 * SECOND) is not None


def test_corrections_change_the_colour() -> None:
    for corrections, corrected in ((0, False), (2, True)):
        target = make_target("t-1", SECOND, corrections=corrections)
        scene = compose(history(SECOND), target, live=False)
        assert scene.marker is not None
        assert scene.marker.corrected is corrected


@pytest.mark.parametrize(
    ("yaw", "state", "expected"),
    [(0.0, "proposed", SECOND), (0.1, "proposed", -1), (0.0, "confirmed", -1)],
)
def test_an_allowed_area_fits_while_the_operator_decides_and_the_head_keeps_still(
    yaw: float, state: str, expected: int
) -> None:
    target = make_target("t-1", SECOND, state=state)
    own = compose(history(SECOND), target, live=False)
    assert own.area_stamp_ns == (SECOND if state == "proposed" else -1)
    newer = history(SECOND, 2 * SECOND, views=(2 * SECOND,), yaw=yaw)
    assert compose(newer, target, live=False).area_stamp_ns == expected


@given(st.integers(0, 2**32 - 1), st.integers(1, 40), st.integers(1, 40))
def test_the_bits_of_an_area_are_its_allowed_cells(seed: int, rows: int, columns: int) -> None:
    cells = np.random.default_rng(seed).integers(0, 2, (rows, columns)).astype(np.uint8)
    area = AllowedArea(stamp_ns=5, width=64, height=48, cells=cells, reasons=["too steep"])
    news = area_news(area)
    assert (news.stamp, news.rows, news.columns) == ("5", rows, columns)
    bits = np.unpackbits(np.frombuffer(news.bits, np.uint8), count=rows * columns)
    np.testing.assert_array_equal(bits.reshape(rows, columns) == 1, cells == 0)
