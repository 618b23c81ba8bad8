"""Pictures of random scenes agree with the truth written beside them."""

import json
from itertools import product
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from support.pictures import read
from w2c.geometry import Intrinsics, apply, inverse, rotation_from_quaternion, transform
from w2c_sim_robot.scenes import __main__ as scenes_command
from w2c_sim_robot.scenes.render import DEPTH_UNIT, render
from w2c_sim_robot.scenes.scene import load

SIZE = (320, 180)
COUNT = 8
BOXES = ("book", "notebook", "paper", "cereal_box", "box", "tray", "block", "sponge", "crate")


@pytest.fixture(scope="module")
def rendered(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[Any]]:
    """Return a directory of pictures, and what their truth files say."""
    directory = tmp_path_factory.mktemp("pictures")
    paths = list(render(directory, 40, COUNT, SIZE, depth=True))
    return directory, [json.loads(path.read_text()) for path in paths]


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
    """The middle of each thing that is well in view projects into its own box."""
    _, truths = rendered
    checked = 0
    for truth in truths:
        intrinsics = Intrinsics(*truth["intrinsics"])
        camera_from_world = inverse(np.array(truth["world_from_camera"]))
        for item in truth["objects"][1:]:
            if item["visible_pixels"] < 300:
                continue
            middle = np.array([*item["position"][:2], item["position"][2] + item["size"][2] / 2, 1])
            u, v = intrinsics.pixel_from_point((camera_from_world @ middle)[:3])
            left, top, right, bottom = item["box"]
            if left > 2 and right < SIZE[0] - 2 and top > 2 and bottom < SIZE[1] - 2:
                checked += 1
                assert left <= u <= right
                assert top <= v <= bottom
    assert checked >= 5


def test_boxes_are_those_of_the_projected_corners(rendered: tuple[Path, list[Any]]) -> None:
    """What is seen of a thing lies within its projected corners, and mostly fills them."""
    _, truths = rendered
    full = []
    for truth in truths:
        intrinsics = Intrinsics(*truth["intrinsics"])
        camera_from_world = inverse(np.array(truth["world_from_camera"]))
        for item in truth["objects"][1:]:
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
        for item in truth["objects"][1:]:
            # The colour of a mallet is its head's; its wooden handle may be all that is seen.
            if item["colour"] not in hues or item["kind"] == "mallet":
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
        rows, columns = np.nonzero(identity == truth["objects"][0]["id"])
        if len(rows) < 0.3 * identity.size:  # seen from far aside, the edges are most of it
            continue
        z = depth[rows, columns] * DEPTH_UNIT
        fx, fy, cx, cy = truth["intrinsics"]
        points = np.column_stack(
            [(columns + 0.5 - cx) / fx * z, (rows + 0.5 - cy) / fy * z, z, np.ones(len(z))]
        )
        heights = (points @ np.array(truth["world_from_camera"]).T)[:, 2]

        # Edges are smoothed over; the surface itself is not.
        assert np.median(heights) == pytest.approx(truth["objects"][0]["size"][2], abs=1e-3)
        checked += 1
    assert checked >= 2


def test_a_picture_depends_on_its_seed_alone_and_sets_can_be_continued(
    rendered: tuple[Path, list[Any]], tmp_path: Path
) -> None:
    directory, _ = rendered

    list(render(tmp_path, 42, 1, SIZE))
    kept = (tmp_path / "0000042.jpg").stat().st_mtime_ns
    list(render(tmp_path, 42, 1, SIZE, resume=True))

    assert (tmp_path / "0000042.jpg").read_bytes() == (directory / "0000042.jpg").read_bytes()
    assert (tmp_path / "0000042.jpg").stat().st_mtime_ns == kept


def test_the_command_writes_scene_files(tmp_path: Path) -> None:
    path = tmp_path / "scene.json"

    status = scenes_command.main(["make", "--out", str(path), "--book", "0.45", "-0.2"])

    assert status == 0
    assert load(path).object("book").position[:2] == (0.45, -0.2)


def test_the_command_says_what_is_wrong(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status = scenes_command.main(["make", "--out", str(tmp_path / "s.json"), "--cup", "3.0", "0.0"])

    assert status == 2
    assert "not on the table" in capsys.readouterr().err
