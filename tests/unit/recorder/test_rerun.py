"""A file for Rerun has typed columns of what was recorded, and is there whole or not at all."""

import sys
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader

from support.disk import file_size_limit
from support.robots import robot_session
from support.sessions import Session
from w2c.errors import ConfigError, MissingExtraError, RecordingError
from w2c_recorder.commands import recording
from w2c_recorder.foxglove.copy import copy_shown
from w2c_recorder.reading import Recording
from w2c_recorder.whole_file import whole_file

Columns = dict[str, dict[str, list[Any]]]
"""Entity -> component -> rows"""


def export(source: Path, out: Path) -> int:
    return recording(["export", str(source), "--to", "rerun", "--out", str(out)])


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return robot_session().write(tmp_path_factory.mktemp("rerun") / "session.mcap")


# --- without Rerun


def test_without_the_extra_it_says_what_to_install(
    source: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("write", "typed"):
        monkeypatch.delitem(sys.modules, f"w2c_recorder.rerun.{name}", raising=False)
    monkeypatch.setitem(sys.modules, "rerun", None)

    with pytest.raises(MissingExtraError, match=r"is not installed.* pip install .*\[rerun\]"):
        export(source, tmp_path / "a.rrd")

    assert list(tmp_path.iterdir()) == []


def test_a_file_gets_its_name_when_it_is_whole(tmp_path: Path) -> None:
    out = tmp_path / "new" / "a.rrd"
    with whole_file(out) as unfinished:
        unfinished.write_bytes(b"half")
        unfinished.with_name("other").write_bytes(b"on the way")
        assert not out.exists()
        unfinished.write_bytes(b"whole")

    assert out.read_bytes() == b"whole"
    assert list(out.parent.iterdir()) == [out]


def fails_halfway(out: Path, error: BaseException) -> None:
    with whole_file(out) as unfinished:
        unfinished.write_bytes(b"half")
        raise error


@pytest.mark.parametrize("error", [RecordingError("no room"), KeyboardInterrupt()], ids=repr)
def test_half_a_file_is_none(tmp_path: Path, error: BaseException) -> None:
    with pytest.raises(type(error)):
        fails_halfway(tmp_path / "a.rrd", error)

    assert list(tmp_path.iterdir()) == []


def test_a_file_that_is_there_stays(tmp_path: Path) -> None:
    out = tmp_path / "a.rrd"
    out.write_bytes(b"dear")
    with pytest.raises(ConfigError, match="is there already; remove it"), whole_file(out):
        pytest.fail("it was about to be written")
    assert out.read_bytes() == b"dear"

    with pytest.raises(ConfigError, match="cannot be written"), whole_file(out / "b.rrd"):
        pytest.fail("a file is no directory")


def test_what_is_shown_can_be_written_without_the_bus(source: Path, tmp_path: Path) -> None:
    out = tmp_path / "shown.mcap"
    copied = copy_shown(Recording(source), out, alone=True)

    with out.open("rb") as stream:
        topics = {channel.topic for _, channel, _ in make_reader(stream).iter_messages()}
    assert topics
    assert all(topic.startswith("foxglove/test/") for topic in topics)
    assert (copied.messages, copied.shown > 0, copied.problem) == (0, True, "")


# --- with Rerun


def columns_of(path: Path) -> Columns:
    """Read a file for Rerun."""
    chunk = pytest.importorskip("rerun.chunk", reason="needs the extra rerun")
    found: Columns = defaultdict(lambda: defaultdict(list))
    for one in chunk.RrdReader(path).stream():
        batch = one.to_record_batch()
        for name in batch.schema.names:
            if ":" in name:
                found[one.entity_path][name] += batch.column(name).to_pylist()
    return found


@pytest.fixture(scope="module")
def written(source: Path, tmp_path_factory: pytest.TempPathFactory) -> Columns:
    pytest.importorskip("rerun.chunk", reason="needs the extra rerun")
    out = tmp_path_factory.mktemp("rerun") / "session.rrd"
    assert export(source, out) == 0
    return columns_of(out)


def test_pictures_and_their_camera_have_columns(written: Columns) -> None:
    pictures, camera = written["/foxglove/test/camera/image"], "/foxglove/test/camera/calibration"

    assert pictures["EncodedImage:media_type"] == [["image/jpeg"]] * 2
    assert bytes(pictures["EncodedImage:blob"][0][0])[:2] == b"\xff\xd8"
    assert written[camera]["Pinhole:resolution"][0] == [[64.0, 48.0]]
    assert written[camera]["Pinhole:image_from_camera"][0][0][0] == 50.0


def test_links_are_transforms(written: Columns) -> None:
    links = written["/foxglove/test/tf"]
    parents = [row[0] for row in links["Transform3D:parent_frame"]]
    children = [row[0] for row in links["Transform3D:child_frame"]]
    where = [row[0] for row in links["Transform3D:translation"]]

    assert dict(zip(children, parents, strict=True)) == {
        "base": "world", "left": "base", "right": "base", "sole": "left",
    }  # fmt: skip
    assert where[children.index("base")][2] == pytest.approx(0.45)


def test_the_robot_is_lines_and_the_target_a_ball(written: Columns) -> None:
    robot, target = written["/foxglove/test/robot"], written["/foxglove/test/target"]

    assert len(robot["LineStrips3D:strips"][0]) == 3
    assert robot["CoordinateFrame:frame"] == target["CoordinateFrame:frame"] == [["world"]]
    assert target["Points3D:positions"][0][0] == pytest.approx([0.5, 0.0, 0.8])


def test_marks_lie_in_the_frame_of_the_picture(written: Columns) -> None:
    frame = written["/foxglove/test/camera/image"]["CoordinateFrame:frame"][0]
    point = written["/foxglove/test/camera/target/point"]
    boxes = written["/foxglove/test/camera/target/boxes"]

    assert point["CoordinateFrame:frame"] == boxes["CoordinateFrame:frame"] == [frame]
    assert point["Points2D:positions"] == [[[10.0, 20.0]]]
    assert boxes["Boxes2D:centers"] == [[[2.0, 3.0]]]
    assert boxes["Boxes2D:half_sizes"] == [[[1.0, 1.0]]]
    assert boxes["Boxes2D:labels"] == [["mug 0.50"]]


def test_joints_are_series_with_their_names(written: Columns) -> None:
    positions = written["/foxglove/test/joints/position"]

    assert positions["Scalars:scalars"] == [[0.0, -0.1]]
    assert positions["SeriesLines:names"] == [["slide", "turn"]]


def test_words_and_logs_are_text(written: Columns) -> None:
    assert written["/foxglove/test/log"]["TextLog:text"] == [["slow"]]
    assert written["/story/words"]["TextLog:text"][0] == ['operator: "on the book"']
    assert written["/story/warning"]["TextLog:level"][0] == ["WARN"]


def test_everything_is_on_the_time_of_arrival(source: Path, tmp_path: Path) -> None:
    chunk = pytest.importorskip("rerun.chunk", reason="needs the extra rerun")
    out = tmp_path / "a.rrd"
    export(source, out)

    moving = [one for one in chunk.RrdReader(out).stream() if not one.is_static]
    assert moving
    assert all("message_log_time" in one.timeline_names for one in moving)


def test_of_a_file_that_was_cut_off_what_is_there_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("rerun.chunk", reason="needs the extra rerun")
    whole = robot_session().write(tmp_path / "whole.mcap", close=False).read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole[:-20])

    assert export(cut, tmp_path / "a.rrd") == 0

    assert "was not closed" in capsys.readouterr().out
    assert columns_of(tmp_path / "a.rrd")["/foxglove/test/camera/image"]


def test_a_recording_of_nothing_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("rerun.chunk", reason="needs the extra rerun")

    assert export(Session().write(tmp_path / "a.mcap"), tmp_path / "a.rrd") == 1

    assert "nothing that it shows" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("limit", "reason"),
    [(2_000, "File too large;"), (40_000, "Failed to write")],
    ids=["the channels", "the file itself"],
)
def test_without_room_there_is_no_file(
    source: Path, tmp_path: Path, limit: int, reason: str
) -> None:
    pytest.importorskip("rerun.chunk", reason="needs the extra rerun")
    told = pytest.raises(RecordingError, match=rf"a\.rrd is not written: {reason}.*make room")
    with file_size_limit(limit), told:
        export(source, tmp_path / "a.rrd")

    assert list(tmp_path.iterdir()) == []


def test_ctrl_c_while_it_is_written_comes_out_as_such(
    source: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("rerun.chunk", reason="needs the extra rerun")
    from w2c_recorder.rerun import write

    def pressed(_recording: Recording) -> Iterator[Any]:
        raise KeyboardInterrupt
        yield

    monkeypatch.setattr(write, "timeline_of", pressed)
    with pytest.raises(KeyboardInterrupt):
        export(source, tmp_path / "a.rrd")

    assert list(tmp_path.iterdir()) == []
