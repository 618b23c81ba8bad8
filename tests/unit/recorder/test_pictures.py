"""The picture of an instant carries what was found in it; a page carries all of them."""

import re
from pathlib import Path

import cv2
import numpy as np
import pytest

from support.disk import file_size_limit
from support.sessions import HEIGHT, LATER_STAMP_NS, WIDTH, Session, conversation
from w2c import messages as m
from w2c import topics
from w2c.bus import RawReceived
from w2c.errors import ConfigError, RecordingError
from w2c_recorder.commands import recording
from w2c_recorder.drawing import BOX_COLOUR, decode_picture, draw
from w2c_recorder.history import history_of
from w2c_recorder.overlay import Overlay
from w2c_recorder.pictures import frame_at
from w2c_recorder.reading import Recording


def picture(path: Path, at: float, *, newest: bool = False) -> tuple[m.CameraFrame, Overlay]:
    source = Recording(path)
    history = history_of(source)
    return frame_at(source, history, history.instant(at), newest=newest)


def test_a_target_comes_with_box_and_heat_of_its_phrase(session_file: Path) -> None:
    frame, overlay = picture(session_file, 1.2)

    assert frame.stamp_ns == 5 * 10**9
    assert overlay.point == (40.0, 24.0)
    assert overlay.label == "target-1, proposed"
    assert [(box.left, label) for box, label in overlay.boxes] == [(30.0, "book")]
    assert [heat.shape for heat in overlay.heat] == [(6, 8)]


def test_a_target_that_no_phrase_named_has_neither(session_file: Path) -> None:
    _, overlay = picture(session_file, 2.5)

    assert (overlay.point, overlay.boxes, overlay.heat) == ((20.0, 24.0), (), ())


def test_before_the_first_target_the_newest_picture_is_bare(session_file: Path) -> None:
    frame, overlay = picture(session_file, 0.7)

    assert frame.stamp_ns == 5 * 10**9
    assert overlay == Overlay()


def test_before_the_first_picture_there_is_none(session_file: Path) -> None:
    with pytest.raises(RecordingError, match=r"no picture was recorded before 0\.100 s"):
        picture(session_file, 0.1)


def test_in_a_newer_picture_the_point_is_projected(tmp_path: Path) -> None:
    session = conversation()
    # The camera is 1 m above the target's point and looks down: x right, y down, z forward.
    world_from_camera = np.array(
        [[0.0, -1.0, 0.0, 0.5], [-1.0, 0.0, 0.0, -0.1], [0.0, 0.0, -1.0, 1.8], [0, 0, 0, 1.0]]
    )
    view = m.CameraView(
        stamp_ns=LATER_STAMP_NS, world_from_camera=world_from_camera,
        intrinsics=(50.0, 50.0, 32.0, 24.0), width=WIDTH, height=HEIGHT,
    )  # fmt: skip
    session.add(1.6, topics.CAMERA_VIEW, view)
    frame, overlay = picture(session.write(tmp_path / "a.mcap"), 2.5, newest=True)

    assert frame.stamp_ns == LATER_STAMP_NS
    assert overlay.point == pytest.approx((37.0, 24.0))  # 0.1 m to the right, 1 m away


def test_without_the_pose_of_the_camera_the_label_says_so(session_file: Path) -> None:
    _, overlay = picture(session_file, 2.5, newest=True)

    assert overlay.point is None
    assert overlay.label == "where the camera was is not in the recording"


def test_heat_and_box_and_point_are_in_the_pixels() -> None:
    grey = np.full((HEIGHT, WIDTH, 3), 128, np.uint8)
    heat = np.zeros((HEIGHT, WIDTH), np.uint8)
    heat[10, 10] = 255
    box = m.Box(left=20.0, top=20.0, right=30.0, bottom=30.0, score=0.5)
    drawn = draw(grey, Overlay(point=(50.5, 40.5), boxes=((box, ""),), heat=(heat,)))

    assert drawn[10, 10].tolist() != [128, 128, 128]
    assert drawn[11, 60].tolist() == [128, 128, 128]
    assert tuple(drawn[29, 25].tolist()) == BOX_COLOUR
    assert drawn[40, 50].tolist() != [128, 128, 128]
    assert grey[10, 10].tolist() == [128, 128, 128]  # the original is left alone


def test_bytes_that_are_no_picture_are_an_error() -> None:
    with pytest.raises(RecordingError, match="4 bytes is no JPEG"):
        decode_picture(b"\xff\xd8no")
    with pytest.raises(RecordingError, match="has no bytes"):
        decode_picture(b"")


def test_the_command_writes_the_picture(
    session_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "new" / "frame.png"

    assert recording(["frame", str(session_file), "--at", "0:01.2", "--out", str(out)]) == 0

    drawn = cv2.imread(str(out))
    assert drawn is not None and drawn.shape == (HEIGHT, WIDTH, 3)
    assert "target-1, proposed at (40, 24), 1 boxes, with heat" in capsys.readouterr().out
    with pytest.raises(ConfigError, match=r"ends in none of \.png"):
        recording(["frame", str(session_file), "--at", "1", "--out", str(tmp_path / "a.txt")])


def test_a_time_that_is_none_is_a_usage_error(session_file: Path) -> None:
    with pytest.raises(SystemExit) as exit_info:
        recording(["frame", str(session_file), "--at", "yesterday"])
    assert exit_info.value.code == 2


def test_the_page_holds_story_and_pictures_and_runs_nothing(tmp_path: Path) -> None:
    session = conversation()
    session.add(3.9, topics.MARK, m.MarkRequest(text="<script>alert(1)</script>"))
    page = tmp_path / "story.html"
    recording(["timeline", str(session.write(tmp_path / "a.mcap")), "--html", str(page)])

    text = page.read_text()
    assert len(re.findall(r"<figure>", text)) == 2  # not again for the confirmation
    assert text.count("data:image/jpeg;base64,") == 2
    assert text.count("data:image/png;base64,") == 1
    assert "<script>" not in text
    assert "&lt;script&gt;alert(1)" in text
    assert "default-src 'none'" in text
    assert not re.search(r"(?:src|href)=\"(?!data:)", text)


def test_a_picture_that_was_not_recorded_leaves_the_story(tmp_path: Path) -> None:
    session = Session()
    session.raw = [raw for raw in conversation().raw if "rgbd" not in raw.key]
    page = tmp_path / "story.html"
    recording(["timeline", str(session.write(tmp_path / "a.mcap")), "--html", str(page)])

    assert "<figure>" not in page.read_text()
    assert "to the left" in page.read_text()


def test_the_film_keeps_the_time_of_the_recording(session_file: Path, tmp_path: Path) -> None:
    out = tmp_path / "film.mp4"

    assert recording(["export", str(session_file), "--to", "mp4", "--out", str(out)]) == 0

    film = cv2.VideoCapture(str(out))
    assert film.get(cv2.CAP_PROP_FPS) == 10.0
    # From the first picture at 0.5 s to the end at 4 s, and the last one stays for its moment.
    assert film.get(cv2.CAP_PROP_FRAME_COUNT) == 36
    film.release()


def test_a_film_of_no_pictures_is_an_error(tmp_path: Path) -> None:
    session = conversation()
    session.raw = [raw for raw in session.raw if "rgbd" not in raw.key]

    with pytest.raises(RecordingError, match="holds no picture"):
        recording(["export", str(session.write(tmp_path / "a.mcap")), "--to", "mp4"])


def with_broken_pictures(path: Path, broken: set[int]) -> Path:
    """Write the session with pictures of these numbers that are none."""
    session = conversation()
    for number, raw in enumerate([raw for raw in session.raw if "rgbd" in raw.key]):
        if number in broken:
            torn = raw.payload.replace(b"\xff\xd8\xff", b"\0\0\0")
            assert torn != raw.payload
            session.raw[session.raw.index(raw)] = RawReceived(raw.key, torn, raw.received_ns)
    return session.write(path)


def test_a_picture_that_is_none_does_not_end_the_film(tmp_path: Path) -> None:
    path = with_broken_pictures(tmp_path / "a.mcap", {1})
    out = tmp_path / "film.mp4"

    recording(["export", str(path), "--to", "mp4", "--out", str(out)])

    film = cv2.VideoCapture(str(out))
    assert film.get(cv2.CAP_PROP_FRAME_COUNT) == 36
    film.release()


def test_a_film_of_pictures_that_are_none_is_an_error(tmp_path: Path) -> None:
    path = with_broken_pictures(tmp_path / "a.mcap", {0, 1})

    with pytest.raises(RecordingError, match="no picture of the camera that can be read"):
        recording(["export", str(path), "--to", "mp4", "--out", str(tmp_path / "film.mp4")])


def test_a_film_that_finds_no_room_is_an_error(session_file: Path, tmp_path: Path) -> None:
    out = tmp_path / "film.mp4"

    with (
        file_size_limit(1_000),
        pytest.raises(RecordingError, match=r"film\.mp4 has 0 of 36 frames; make room"),
    ):
        recording(["export", str(session_file), "--to", "mp4", "--out", str(out)])


def test_a_film_below_a_file_is_a_usage_error(session_file: Path) -> None:
    out = session_file / "below" / "film.mp4"

    with pytest.raises(ConfigError, match=r"film\.mp4 cannot be written: Not a directory"):
        recording(["export", str(session_file), "--to", "mp4", "--out", str(out)])
