"""Pictures are found by stamp, with the camera's pose, and forgotten in order."""

import threading

import msgspec
import numpy as np
import pytest

from w2c.errors import RefusedError
from w2c.messages import CameraView
from w2c_dialogue.frames import DEFAULT_PIXELS_PER_CM, FrameStore, pixels_per_cm, project
from w2c_dialogue.interfaces import Frame

MS = 1_000_000


def frame(stamp_ns: int, robot_boot_id: str = "") -> Frame:
    return Frame(stamp_ns, 1280, 720, b"jpeg", robot_boot_id=robot_boot_id)


def view(stamp_ns: int, robot_boot_id: str = "") -> CameraView:
    return CameraView(
        stamp_ns=stamp_ns,
        world_from_camera=np.eye(4),
        intrinsics=(800.0, 800.0, 640.0, 360.0),
        width=1280,
        height=720,
        robot_boot_id=robot_boot_id,
    )


def test_minus_one_is_the_newest_picture_whose_pose_is_known() -> None:
    store = FrameStore()
    store.add_frame(frame(1))
    store.add_frame(frame(2))
    assert store.find(-1).stamp_ns == 2
    store.add_view(view(1))
    found = store.find(-1)
    assert found.stamp_ns == 1
    assert found.view is not None


def test_the_oldest_is_forgotten_and_said() -> None:
    store = FrameStore(kept=2)
    for stamp in (1, 2, 3):
        store.add_frame(frame(stamp))
    with pytest.raises(RefusedError, match="stamp 1"):
        store.find(1, wait_s=60.0)
    assert store.find(2).stamp_ns == 2


@pytest.mark.parametrize("known", [(100, 300), (100, 250), (250, 300)])
def test_a_lost_picture_is_stood_in_for_by_its_neighbour_of_the_same_place(
    known: tuple[int, int],
) -> None:
    """Stamps in milliseconds; that of 250 was lost."""
    store = FrameStore()
    for stamp in (100, 300):
        store.add_frame(frame(stamp * MS))
    for stamp in known:
        store.add_view(view(stamp * MS))
    assert store.find(250 * MS).stamp_ns == 300 * MS


@pytest.mark.parametrize(
    ("shift_m", "turn", "later_ms"), [(0.01, 0.0, 300), (0.0, 0.01, 300), (0.0, 0.0, 1500)]
)
def test_a_lost_picture_has_no_stand_in_where_the_camera_moved_or_long_after(
    shift_m: float, turn: float, later_ms: int
) -> None:
    store = FrameStore()
    for stamp in (100, later_ms):
        store.add_frame(frame(stamp * MS))
    store.add_view(view(100 * MS))
    moved = np.eye(4)
    moved[0, 3], moved[0, 1] = shift_m, turn
    later = msgspec.structs.replace(view(later_ms * MS), world_from_camera=moved)
    store.add_view(later)
    with pytest.raises(RefusedError, match="not among the last 2"):
        store.find(250 * MS)


def test_a_picture_on_its_way_is_waited_for_with_its_pose() -> None:
    store = FrameStore()
    store.add_frame(frame(1))
    store.add_view(view(1))
    found: list[Frame] = []
    thread = threading.Thread(target=lambda: found.append(store.find(2, wait_s=60.0)))
    thread.start()
    store.add_frame(frame(2))
    store.add_view(view(2))
    thread.join(10.0)
    assert found
    assert found[0].stamp_ns == 2
    assert found[0].view is not None


def test_the_first_picture_of_all_is_waited_for_where_the_operator_saw_it() -> None:
    store = FrameStore()
    found: list[Frame] = []
    thread = threading.Thread(target=lambda: found.append(store.find(2, wait_s=60.0)))
    thread.start()
    thread.join(0.05)
    store.add_frame(frame(2))
    thread.join(10.0)
    assert [one.stamp_ns for one in found] == [2]
    with pytest.raises(RefusedError, match="Look at the live picture"):
        FrameStore().find(2)


def waits_for_its_first_picture(store: FrameStore) -> None:
    found: list[Frame] = []
    thread = threading.Thread(target=lambda: found.append(store.find(-1, wait_s=60.0)))
    thread.start()
    thread.join(timeout=0.1)
    assert thread.is_alive()
    store.add_frame(frame(1))
    thread.join(timeout=10.0)
    assert [one.stamp_ns for one in found] == [1]


def test_a_dialogue_that_has_just_begun_waits_for_its_first_picture() -> None:
    waits_for_its_first_picture(FrameStore())


def test_no_camera_is_waited_for_once_and_then_said_at_once() -> None:
    store = FrameStore()
    with pytest.raises(RefusedError, match="camera does not send"):
        store.find(-1, wait_s=0.01)
    with pytest.raises(RefusedError, match="camera does not send"):
        store.find(-1, wait_s=60.0)
    store.add_frame(frame(1))
    assert store.find(-1, wait_s=60.0).stamp_ns == 1


def test_a_look_without_patience_does_not_use_up_that_of_the_first_picture() -> None:
    store = FrameStore()
    with pytest.raises(RefusedError, match="camera does not send"):
        store.find(-1)
    waits_for_its_first_picture(store)


def test_without_patience_no_camera_is_said_at_once() -> None:
    with pytest.raises(RefusedError, match="camera does not send"):
        FrameStore().find(-1)


def test_a_picture_of_before_the_robot_started_anew_is_refused_though_its_stamp_came_again() -> (
    None
):
    store = FrameStore()
    seen = frame(1, "first")
    store.add_frame(seen)
    store.add_frame(frame(2, "first"))
    store.add_view(view(1, "first"))
    assert store.find(1, "first").view is not None

    store.add_frame(frame(1, "second"))

    assert not store.current(seen)
    with pytest.raises(RefusedError, match="started anew"):
        store.find(1, "first")
    with pytest.raises(RefusedError, match="stamp 2"):
        store.find(2, "second")
    # The pose of the former robot's picture is not that of this one's.
    assert store.find(1, "second").view is None
    store.add_view(view(1, "second"))
    assert store.find(1, "second").view is not None
    assert store.find(-1, "first").robot_boot_id == "second", "no picture was seen: none is checked"


def test_time_that_jumps_back_is_a_robot_that_started_anew() -> None:
    """Where the camera does not say whose pictures they are."""
    store = FrameStore()
    store.add_frame(frame(1000))
    store.add_frame(frame(3))
    with pytest.raises(RefusedError, match="stamp 1000"):
        store.find(1000)


def test_projection_and_scale() -> None:
    point = np.array([0.1, -0.05, 0.8])
    assert project(point, view(1)) == pytest.approx((740.0, 310.0))
    assert project(np.array([0.0, 0.0, -1.0]), view(1)) is None
    assert project(np.array([5.0, 0.0, 1.0]), view(1)) is None
    assert pixels_per_cm(point, view(1)) == pytest.approx(10.0)
    assert pixels_per_cm(point * 2, view(1)) == pytest.approx(5.0)
    assert pixels_per_cm(None, view(1)) == DEFAULT_PIXELS_PER_CM
