"""The memory of pictures and joint angles: what is kept, interpolated, refused."""

import numpy as np
import pytest

from w2c.depth import encode_depth
from w2c.errors import MessageError, RefusedError
from w2c.messages import CameraFrame
from w2c.stance import Stance, both_feet
from w2c_perception.buffer import MAX_GAP_NS, StateBuffer, View, ViewBuffer
from w2c_perception.pose import CameraPose

SECOND = 1_000_000_000
POSE = CameraPose(np.eye(4), np.zeros((0, 2, 3)), np.zeros((1, 6)))
STANDS = both_feet((np.eye(4), np.eye(4)), world=1)


def view(stamp_ns: int, depth: bytes = b"") -> View:
    frame = CameraFrame(
        stamp_ns=stamp_ns,
        frame="camera",
        width=8,
        height=4,
        intrinsics=(10.0, 10.0, 4.0, 2.0),
        jpeg=b"",
        depth=depth,
    )
    return View(frame, POSE, np.zeros(1))


def test_views_are_found_by_their_stamp() -> None:
    views = ViewBuffer(10.0, 100)
    for stamp in (100, 200, 300):
        views.add(view(stamp))

    assert views.get(200).stamp_ns == 200


@pytest.mark.parametrize(
    ("stamp", "reason"),
    [
        (50, r"0\.0 s older than the oldest; there are 2 from 100 to 5000000000 ns"),
        (7 * SECOND, r"2\.0 s newer than the newest"),
        (150, "no picture was taken then"),
    ],
)
def test_a_wrong_stamp_is_refused_and_told_what_there_is(stamp: int, reason: str) -> None:
    views = ViewBuffer(10.0, 100)
    views.add(view(100))
    views.add(view(5 * SECOND))

    with pytest.raises(RefusedError, match=reason):
        views.get(stamp)


def test_an_empty_memory_asks_whether_the_camera_runs() -> None:
    with pytest.raises(RefusedError, match="is the camera running"):
        ViewBuffer(10.0, 100).get(1)


def test_old_and_surplus_views_are_forgotten() -> None:
    views = ViewBuffer(history_s=2.0, max_frames=3)
    for stamp in range(0, 6 * SECOND, SECOND):
        views.add(view(stamp))

    assert views.stamps() == [3 * SECOND, 4 * SECOND, 5 * SECOND]

    views.add(view(6 * SECOND + 1))
    assert views.stamps() == [5 * SECOND, 6 * SECOND + 1]


def test_a_robot_that_starts_anew_makes_old_views_worthless() -> None:
    views = ViewBuffer(10.0, 100)
    views.add(view(5 * SECOND))
    views.add(view(SECOND))

    assert views.stamps() == [SECOND]


def test_a_view_of_the_same_instant_replaces_the_former() -> None:
    views = ViewBuffer(10.0, 100)
    views.add(view(1))
    newer = view(1)
    views.add(newer)

    assert views.get(1) is newer


def test_depth_is_unpacked_and_a_broken_one_is_an_error() -> None:
    depth = np.full((4, 8), 1.25, np.float32)

    assert view(1, encode_depth(depth)).unpack_depth()[:].tolist() == depth.tolist()
    assert not view(1).unpack_depth()[:].any()
    with pytest.raises(MessageError):
        view(1, b"broken").unpack_depth()


def test_joint_angles_are_linear_between_measurements() -> None:
    states = StateBuffer(10.0)
    states.add(0, np.array([0.0, 1.0]), STANDS)
    states.add(10_000_000, np.array([0.1, 0.8]), STANDS)

    quarter = states.at(2_500_000)

    assert quarter.position == pytest.approx([0.025, 0.95])
    # Nothing tells how the angles moved in between, so the step of 0.2 rad is taken for its bend.
    assert quarter.uncertainty == pytest.approx(0.5 * 0.25 * 0.75 * 0.2)
    assert states.at(10_000_000).position.tolist() == [0.1, 0.8]
    assert states.at(10_000_000).uncertainty == 0.0


def test_a_steady_motion_leaves_no_doubt() -> None:
    states = StateBuffer(10.0)
    for stamp in range(0, SECOND // 10, 10_000_000):
        states.add(stamp, np.array([stamp * 1e-9]), STANDS)

    assert states.at(35_000_000).position == pytest.approx([0.035])
    assert states.at(35_000_000).uncertainty == pytest.approx(0.0, abs=1e-12)


def test_interpolation_of_a_swing_stays_within_its_own_doubt() -> None:
    def angle(stamp_ns: int) -> float:
        return float(0.3 * np.sin(2 * np.pi * 1.5 * stamp_ns * 1e-9))

    states = StateBuffer(10.0)
    for stamp in range(0, SECOND, 10_000_000):
        states.add(stamp, np.array([angle(stamp)]), STANDS)

    for stamp in range(1_000_000, SECOND - 20_000_000, 7_777_777):
        between = states.at(stamp)
        assert abs(between.position[0] - angle(stamp)) <= 1.2 * between.uncertainty


@pytest.mark.parametrize("stamp", [5, 10 * MAX_GAP_NS])
def test_angles_outside_of_the_measurements_are_refused(stamp: int) -> None:
    states = StateBuffer(10.0)
    states.add(10, np.zeros(1), STANDS)
    states.add(20, np.zeros(1), STANDS)

    with pytest.raises(RefusedError, match="from 10 to 20 ns"):
        states.at(stamp)


def test_a_gap_is_not_interpolated() -> None:
    states = StateBuffer(10.0)
    states.add(0, np.zeros(1), STANDS)
    states.add(MAX_GAP_NS + 1, np.ones(1), STANDS)

    with pytest.raises(RefusedError, match="no joint angles for 100 ms"):
        states.at(MAX_GAP_NS // 2)


def test_before_the_first_angles_the_robot_is_asked_for() -> None:
    with pytest.raises(RefusedError, match="is the robot running"):
        StateBuffer(10.0).at(0)


def test_angles_grow_old() -> None:
    states = StateBuffer(1.0)
    for stamp in range(0, 3 * SECOND, SECOND // 20):
        states.add(stamp, np.zeros(1), STANDS)

    with pytest.raises(RefusedError):
        states.at(SECOND)
    assert states.at(2 * SECOND + 1).position.tolist() == [0.0]


def test_time_that_jumps_back_clears_the_angles() -> None:
    states = StateBuffer(10.0)
    assert states.add(5 * SECOND, np.zeros(1), STANDS)
    assert not states.add(SECOND, np.ones(1), STANDS)

    assert states.newest_ns == SECOND
    assert states.at(SECOND).position.tolist() == [1.0]


def test_angles_tell_the_velocity() -> None:
    states = StateBuffer(10.0)
    states.add(0, np.array([0.0, 1.0]), STANDS)
    states.add(10_000_000, np.array([0.01, 0.98]), STANDS)

    assert states.at(4_000_000).velocity == pytest.approx([1.0, -2.0])
    assert states.at(10_000_000).velocity == pytest.approx([1.0, -2.0])
    assert states.at(0).velocity.tolist() == [0.0, 0.0]


def test_between_two_stances_only_the_feet_of_both_count() -> None:
    one = Stance((True, False), STANDS.anchors, STANDS.world)
    states = StateBuffer(10.0)
    for stamp, stance in ((0, STANDS), (10, one), (20, STANDS)):
        states.add(stamp, np.zeros(1), stance)

    assert states.at(5).stance is one
    assert states.at(15).stance is one
    assert states.at(20).stance is STANDS


@pytest.mark.parametrize("other", [None, both_feet((np.eye(4), np.eye(4)), world=2)])
def test_while_no_foot_stands_nothing_has_a_place(other: Stance | None) -> None:
    states = StateBuffer(10.0)
    states.add(0, np.zeros(1), STANDS)
    states.add(10, np.zeros(1), other)

    with pytest.raises(RefusedError, match="no foot stood"):
        states.at(5)


def test_a_turning_camera_blurs_a_view_and_a_still_one_does_not() -> None:
    turning = CameraPose(np.eye(4), np.zeros((0, 2, 3)), np.array([[0, 0, 0, 0, 1.0, 0]]))
    frame = view(1).frame
    moving = View(frame, turning, np.array([0.5]))
    depth = np.full((4, 8), 2.0, np.float32)

    # About its axis downwards with 0.5 rad/s, focal length 10 px: 5 px/s in the middle.
    assert moving.blur(depth, 4.0, 2.0, 0.1) == pytest.approx(0.5)
    assert moving.blur(depth, 4.0, 2.0, 0.0) == 0.0
    assert moving.blur(depth, float("nan"), 2.0, 0.1) == 0.0
    assert view(1).blur(depth, 4.0, 2.0, 0.1) == 0.0
