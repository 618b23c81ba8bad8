"""Pictures of random scenes agree with the truth written beside them."""

import errno
import json
from itertools import product
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from support.pictures import read
from w2c.errors import ConfigError, W2CError
from w2c.geometry import Intrinsics, apply, inverse, rotation_from_quaternion, transform
from w2c_sim_robot.scenes import __main__ as scenes_command
from w2c_sim_robot.scenes.objects.catalogue import KINDS
from w2c_sim_robot.scenes.picture_set import PictureSet, SetDescription
from w2c_sim_robot.scenes.render import DEPTH_UNIT, render
from w2c_sim_robot.scenes.scene import load

SIZE = (320, 180)
COUNT = 8
PARTLY_COLOURED = (
    "mallet",
    "flower_pot",
    "lamp",
    "jar",
    "cheez_it_box",
    "stapler",
    "drill",
    "hammer",
)
"""Other parts of them may be all that is seen"""
SET = SetDescription(width=SIZE[0], height=SIZE[1])
BOXES = (
    "book",
    "notebook",
    "paper",
    "cereal_box",
    "box",
    "tray",
    "block",
    "sponge",
    "crate",
    "cheez_it_box",
    "cutting_board",
)


@pytest.fixture(scope="module")
def rendered(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[Any]]:
    """Return a directory of pictures, and what their truth files say."""
    directory = tmp_path_factory.mktemp("pictures")
    paths = list(render(directory, 40, COUNT, SET))
    return directory, [json.loads(path.read_text()) for path in paths]


def things(truth: Any) -> list[Any]:
    """Return the objects that are no furniture."""
    return [item for item in truth["objects"] if not KINDS[item["kind"]].furniture]


def test_each_seed_gives_its_files(rendered: tuple[Path, list[Any]]) -> None:
    directory, truths = rendered

    assert [truth["seed"] for truth in truths] == list(range(40, 40 + COUNT))
    for truth in truths:
        picture = read(directory / truth["image"])
        assert picture.shape == (SIZE[1], SIZE[0], 3)
        assert picture.std() > 10


def test_boxes_and_pixel_counts_are_those_of_the_identity_picture(
    rendered: tuple[Path, list[Any]],
) -> None:
    directory, truths = rendered
    visible = 0
    for truth in truths:
        identity = read(directory / truth["identity"])
        for item in truth["objects"]:
            rows, columns = np.nonzero(identity == item["id"])
            assert item["visible_pixels"] == len(rows)
            if len(rows):
                visible += 1
                left, top, right, bottom = item["box"]
                assert (left, top) == (columns.min(), rows.min())
                assert (right, bottom) == (columns.max() + 1, rows.max() + 1)
            else:
                assert item["box"] is None
    assert visible > 3 * COUNT


def test_an_object_is_seen_where_its_pose_says(rendered: tuple[Path, list[Any]]) -> None:
    """The middle of most things that are well in view shows that thing: few hide it."""
    directory, truths = rendered
    hits = []
    for truth in truths:
        intrinsics = Intrinsics(*truth["intrinsics"])
        camera_from_world = inverse(np.array(truth["world_from_camera"]))
        identity = read(directory / truth["identity"])
        for item in things(truth):
            if item["visible_pixels"] < 300:
                continue
            pose = transform(rotation_from_quaternion(item["orientation"]), item["position"])
            middle = camera_from_world @ pose @ [0.0, 0.0, item["size"][2] / 2, 1.0]
            u, v = intrinsics.pixel_from_point(middle[:3])
            if 0 <= u < SIZE[0] and 0 <= v < SIZE[1]:
                hits.append(identity[int(v), int(u)] == item["id"])
    assert len(hits) >= 12
    assert np.mean(hits) > 0.75


def test_boxes_are_those_of_the_projected_corners(rendered: tuple[Path, list[Any]]) -> None:
    """What is seen of a thing lies within its projected corners, and mostly fills them."""
    _, truths = rendered
    full = []
    for truth in truths:
        intrinsics = Intrinsics(*truth["intrinsics"])
        camera_from_world = inverse(np.array(truth["world_from_camera"]))
        for item in things(truth):
            if item["kind"] not in BOXES:
                continue
            size = np.array(item["size"])
            corners = np.array(list(product((-0.5, 0.5), (-0.5, 0.5), (0.0, 1.0)))) * size
            pose = transform(rotation_from_quaternion(item["orientation"]), item["position"])
            pixels = np.array(
                [intrinsics.pixel_from_point(p) for p in apply(camera_from_world @ pose, corners)]
            )
            low = np.clip(pixels.min(axis=0), 0, SIZE)
            high = np.clip(pixels.max(axis=0), 0, SIZE)
            if (high - low).min() < 8:
                continue  # outside of the picture
            if item["box"] is None:
                full.append(False)
                continue
            assert (np.array(item["box"][:2]) >= low - 2).all(), item
            assert (np.array(item["box"][2:]) <= high + 2).all(), item
            gap = np.abs(np.array(item["box"]) - np.concatenate([low, high]))
            full.append(bool(gap.max() < 4))
    assert len(full) >= 8
    assert np.mean(full) > 0.4  # arms and other things hide some


def test_a_thing_has_the_colour_that_the_truth_names(rendered: tuple[Path, list[Any]]) -> None:
    directory, truths = rendered
    checked = 0
    hues = {"red": 0, "green": 65, "blue": 112, "yellow": 25}
    for truth in truths:
        hsv = cv2.cvtColor(read(directory / truth["image"]), cv2.COLOR_BGR2HSV)
        identity = read(directory / truth["identity"])
        for item in things(truth):
            if item["colour"] not in hues or item["kind"] in PARTLY_COLOURED:
                continue
            if item["visible_pixels"] < 300:
                continue
            pixels = hsv[identity == item["id"]].astype(int)
            vivid = pixels[pixels[:, 1] > 100]
            off = np.abs((vivid[:, 0] - hues[item["colour"]] + 90) % 180 - 90)
            checked += 1
            assert np.median(off) < 22, item
    assert checked >= 4


def test_depth_puts_the_table_top_at_its_height(rendered: tuple[Path, list[Any]]) -> None:
    directory, truths = rendered
    checked = 0
    for truth in truths:
        depth = read(directory / f"{truth['seed']:07d}_depth.png")
        identity = read(directory / truth["identity"])
        if truth["objects"][0]["kind"] not in ("table", "counter"):
            continue
        rows, columns = np.nonzero(identity == truth["objects"][0]["id"])
        if len(rows) < 0.3 * identity.size:  # seen from far aside, the edges are most of it
            continue
        z = depth[rows, columns] * DEPTH_UNIT
        fx, fy, cx, cy = truth["intrinsics"]
        points = np.column_stack(
            [(columns + 0.5 - cx) / fx * z, (rows + 0.5 - cy) / fy * z, z, np.ones(len(z))]
        )
        heights = (points @ np.array(truth["world_from_camera"]).T)[:, 2]

        assert np.median(heights) == pytest.approx(truth["objects"][0]["size"][2], abs=1e-3)
        checked += 1
    assert checked >= 2


def test_a_picture_depends_on_its_seed_alone_and_sets_can_be_shared_out_and_continued(
    rendered: tuple[Path, list[Any]], tmp_path: Path
) -> None:
    directory, _ = rendered

    list(render(tmp_path, 42, 1, SET, jobs=2))
    kept = (tmp_path / "0000042.png").stat().st_mtime_ns
    with pytest.raises(ConfigError, match="has 1 of these 1 pictures already; add --resume"):
        list(render(tmp_path, 42, 1, SET))
    list(render(tmp_path, 42, 1, SET, resume=True))

    assert (tmp_path / "0000042.png").read_bytes() == (directory / "0000042.png").read_bytes()
    assert (tmp_path / "0000042.png").stat().st_mtime_ns == kept
    with pytest.raises(ConfigError, match="holds another set: width 320, not 160"):
        list(render(tmp_path, 42, 1, SetDescription(width=160, height=180), resume=True))


def test_parts_lie_within_their_thing(rendered: tuple[Path, list[Any]]) -> None:
    seen = 0
    for _, truths in [rendered]:
        for item in (item for truth in truths for item in truth["objects"]):
            for part in item["parts"]:
                assert part["visible_pixels"] <= item["visible_pixels"]
                if part["box"] is not None:
                    seen += 1
                    assert part["box"][0] >= item["box"][0] and part["box"][1] >= item["box"][1]
                    assert part["box"][2] <= item["box"][2] and part["box"][3] <= item["box"][3]
    assert seen >= 10


def test_phrases_of_its_own_fit_no_other_thing(rendered: tuple[Path, list[Any]]) -> None:
    _, truths = rendered
    for truth in truths:
        for item in truth["objects"]:
            assert set(item["own_phrases"]) <= set(item["phrases"])
            for other in truth["objects"]:
                if other is not item:
                    assert not set(item["own_phrases"]) & set(other["phrases"])


def test_depth_is_that_of_one_surface_even_at_edges(rendered: tuple[Path, list[Any]]) -> None:
    """No point hangs in the air between a thing and what is behind it."""
    directory, truths = rendered
    checked = 0
    for truth in truths:
        depth = read(directory / f"{truth['seed']:07d}_depth.png") * DEPTH_UNIT
        identity = read(directory / truth["identity"])
        fx, fy, cx, cy = truth["intrinsics"]
        for item in things(truth):
            if item["kind"] not in BOXES or item["visible_pixels"] < 200:
                continue
            rows, columns = np.nonzero(identity == item["id"])
            z = depth[rows, columns]
            points = np.column_stack(
                [(columns + 0.5 - cx) / fx * z, (rows + 0.5 - cy) / fy * z, z, np.ones(len(z))]
            )
            pose = transform(rotation_from_quaternion(item["orientation"]), item["position"])
            inside = points @ (inverse(pose) @ np.array(truth["world_from_camera"])).T
            half = np.array(item["size"][:2]) / 2
            assert (np.abs(inside[:, :2]) <= half + 0.006).all(), item["name"]
            checked += 1
    assert checked >= 3


def test_a_directory_with_other_files_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("precious")

    with pytest.raises(ConfigError, match=r"holds files that are no pictures .*thesis\.tex"):
        PictureSet(tmp_path, SET).open(0, 1, resume=True)

    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def test_a_full_disk_is_said_and_leaves_no_half_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    files = PictureSet(tmp_path, SET)
    files.open(0, 1, resume=False)

    def full(_path: Path, _data: bytes) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(W2CError, match=r"the disk is full: .*0000000\.png.*--resume"):
        files.write("0000000.png", b"data")

    assert [path.name for path in tmp_path.iterdir()] == ["set.json"]


@pytest.mark.parametrize(
    ("flags", "complaint"),
    [
        (["--count", "0"], "--count 0: expected `int` >= 1"),
        (["--width", "0", "--height", "0"], "--width 0: expected `int` >= 16"),
        (["--paper-share", "2"], "--paper-share 2.0: expected `float` <= 1.0"),
    ],
)
def test_flags_out_of_range_are_named(
    flags: list[str], complaint: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert scenes_command.main(["render", "--out", str(tmp_path), *flags]) == 2
    assert complaint in capsys.readouterr().err


def test_the_command_writes_scene_files(tmp_path: Path) -> None:
    path = tmp_path / "scene.json"

    status = scenes_command.main(["make", "--out", str(path), "--book", "0.45", "-0.2"])

    assert status == 0
    assert load(path).object("book").position[:2] == (0.45, -0.2)


def test_the_command_says_what_is_wrong(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status = scenes_command.main(["make", "--out", str(tmp_path / "s.json"), "--cup", "3.0", "0.0"])

    assert status == 2
    assert "not on the table" in capsys.readouterr().err
