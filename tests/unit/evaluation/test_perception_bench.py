"""The measurement of perception: its sensors, its truth, its numbers, its command."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from w2c.errors import ConfigError
from w2c.geometry import apply
from w2c.library import library
from w2c_evaluation.perception import commands, trial
from w2c_evaluation.perception.commands import bench
from w2c_evaluation.perception.report import make_rows, missed
from w2c_evaluation.perception.sensors import SensorErrors, near_edges, random_holes
from w2c_evaluation.perception.trial import PixelResult, SceneResult, run_scene
from w2c_perception.kinematics import CameraKinematics
from w2c_sim_robot.description import make_description
from w2c_sim_robot.survey import Survey, kept_survey, survey

SCENE = 900_123
SIZE = (320, 180)


@pytest.fixture(scope="module")
def surveyed() -> Survey:
    return survey(SCENE, 12, size=SIZE)


def pixel(**changes: Any) -> PixelResult:
    values: dict[str, Any] = {
        "u": 1.0,
        "v": 2.0,
        "name": "table",
        "support": "carries",
        "depth": 1.0,
        "known": True,
        "camera_error": 0.001,
        "camera_bound": 0.002,
        "world_error": 0.003,
        "world_bound": 0.004,
        "normal_error": 0.01,
        "milliseconds": 5.0,
        "milliseconds_again": 2.0,
    }
    return PixelResult(**(values | changes))


def rows_of(*pixels: PixelResult) -> dict[tuple[str, str], dict[str, Any]]:
    rows = make_rows([SceneResult(scene=1, pixels=list(pixels))])
    return {(entry["case"], entry["metric"]): entry for entry in rows}


def test_noise_grows_with_the_square_of_depth() -> None:
    errors = replace(SensorErrors(), holes=0.0)
    rng = np.random.default_rng(0)
    for depth in (0.5, 1.0, 2.0):
        measured = errors.depth(np.full((200, 200), depth, np.float32), rng)
        assert np.std(measured) == pytest.approx(0.001 + 0.0015 * depth**2, rel=0.05)
        assert np.mean(measured) == pytest.approx(depth, abs=1e-4)


def test_two_pixels_on_either_side_of_an_edge_are_lost() -> None:
    depth = np.full((40, 60), 1.0, np.float32)
    depth[:, 30:] = 1.4

    lost = near_edges(depth, 2)

    assert np.flatnonzero(lost[20]).tolist() == [28, 29, 30, 31]
    assert not near_edges(depth, 0).any()


def test_a_slope_is_no_edge_however_steep() -> None:
    columns = np.mgrid[0:40, 0:60][1]

    assert not near_edges((1.0 + 0.02 * columns).astype(np.float32), 2).any()


def test_holes_cover_their_share() -> None:
    holes = random_holes((720, 1280), 0.02, np.random.default_rng(0))

    assert np.mean(holes) == pytest.approx(0.02, abs=0.002)
    assert not random_holes((72, 128), 0.0, np.random.default_rng(0)).any()


def test_joints_have_a_constant_bias_and_a_little_noise() -> None:
    errors = SensorErrors()
    measured = errors.position(np.zeros(10_000), np.random.default_rng(0))

    assert np.std(measured) == pytest.approx(np.radians(np.hypot(0.02, 0.05 / np.sqrt(3))), rel=0.1)
    assert not errors.depth(np.zeros((4, 4), np.float32), np.random.default_rng(0)).any()


def test_the_truth_of_a_survey_agrees_with_itself(surveyed: Survey) -> None:
    """The points of the pixels are where their rays meet what the picture shows around them."""
    for (u, v), point, normal in zip(
        surveyed.pixels, surveyed.points, surveyed.normals, strict=True
    ):
        assert surveyed.intrinsics.pixel_from_point(point) == pytest.approx((u, v), abs=1e-6)
        row, column = int(v), int(u)
        near = surveyed.depth[max(0, row - 1) : row + 2, max(0, column - 1) : column + 2]
        assert near.min() - 1e-3 <= point[2] <= near.max() + 1e-3
        assert normal @ point < 0.0
        assert np.linalg.norm(normal) == pytest.approx(1.0)
    assert len(surveyed.names) == len(surveyed.supports) == 12
    assert "robot" not in surveyed.supports


def test_the_camera_of_a_survey_is_where_forward_kinematics_has_it(surveyed: Survey) -> None:
    pose = CameraKinematics(make_description()).camera_pose(surveyed.position)

    assert pose.world_from_camera == pytest.approx(surveyed.world_from_camera, abs=1e-9)
    level = [
        apply(surveyed.world_from_camera, point)[2]
        for point, name in zip(surveyed.points, surveyed.names, strict=True)
        if name == "room"
    ]
    assert min(level, default=0.0) > -1e-6  # nothing is below the floor


@pytest.mark.parametrize(
    ("seed", "count", "size"), [(-1, 1, (8, 8)), (0, 0, (8, 8)), (0, 1, (0, 8))]
)
def test_a_survey_of_nothing_is_refused(seed: int, count: int, size: tuple[int, int]) -> None:
    with pytest.raises(ConfigError, match="expected a seed"):
        survey(seed, count, size=size)


def test_kept_pictures_are_the_same_and_a_broken_one_is_told(
    tmp_path: Path, surveyed: Survey, monkeypatch: pytest.MonkeyPatch
) -> None:
    from w2c_sim_robot import survey as module

    made = []

    def make(*_: object) -> Survey:
        made.append(1)
        return surveyed

    monkeypatch.setattr(module, "survey", make)
    first = kept_survey(SCENE, 12, str(tmp_path))
    second = kept_survey(SCENE, 12, str(tmp_path))

    assert len(made) == 1
    assert second.depth.tolist() == first.depth.tolist()
    assert second.names == first.names
    assert second.intrinsics == first.intrinsics
    next(tmp_path.iterdir()).write_bytes(b"half")
    with pytest.raises(ConfigError, match="empty the directory"):
        kept_survey(SCENE, 12, str(tmp_path))


def test_a_scene_is_lifted_and_judged(surveyed: Survey, monkeypatch: pytest.MonkeyPatch) -> None:
    def offered(name: str) -> Any:
        return (lambda *_: surveyed) if name == "survey" else library(name)

    monkeypatch.setattr(trial, "library", offered)

    result, again = (run_scene(SCENE, 12, "", SensorErrors()) for _ in range(2))

    answered = [pixel for pixel in result.pixels if not pixel.refusal]
    assert len(result.pixels) == 12
    assert len(answered) >= 8
    assert np.median([pixel.camera_error for pixel in answered]) < 0.002
    assert all(pixel.world_bound > pixel.camera_bound > 0.0 for pixel in answered)
    assert [p.camera_error for p in result.pixels] == [p.camera_error for p in again.pixels]


def test_rows_are_medians_percentiles_and_shares() -> None:
    rows = rows_of(
        pixel(),
        pixel(support="room", camera_error=0.005, normal_error=0.03),
        pixel(support="fragile", camera_error=0.04, camera_bound=0.05),
        pixel(refusal="no depth", camera_error=-1.0),
        pixel(refusal="no depth", known=False),
    )

    assert rows["all", "point_error_median"]["value"] == pytest.approx(5.0)
    assert rows["all", "point_error_median"]["n"] == 3
    assert rows["all", "bound_covers"]["value"] == pytest.approx(2 / 3)
    assert rows["all", "refused"]["value"] == pytest.approx(0.4)
    assert rows["all", "refused_wrongly"]["value"] == pytest.approx(0.2)
    assert rows["all", "other_surface"]["value"] == pytest.approx(1 / 3)
    assert rows["load_bearing", "point_error_p95"]["value"] == pytest.approx(1.0)
    assert rows["room", "normal_error_median"]["value"] == pytest.approx(np.degrees(0.03))
    assert rows["other_things", "point_error_median"]["value"] == pytest.approx(40.0)


def test_targets_that_are_missed_are_named_and_nothing_measured_is_missed() -> None:
    assert missed(list(rows_of(pixel()).values())) == []
    slow = missed(list(rows_of(pixel(milliseconds=11.0)).values()))
    assert slow == ["all time_median: 11 ms, limit 10"]
    assert len(missed(list(rows_of(pixel(refusal="x")).values()))) == 3  # only the time is known


def test_the_command_writes_results_and_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    asked: list[tuple[int, int]] = []

    def run(_function: object, tasks: list[tuple[int, int, str, object]], **_: object) -> Any:
        for scene, count, _pictures, _errors in tasks:
            asked.append((scene, count))
            yield SceneResult(scene=scene, pixels=[pixel()] * count)

    monkeypatch.setattr(commands, "run_all", run)
    flags = ["--seed", "7", "--pixels", "4", "--run-directory", str(tmp_path / "run")]

    assert bench([*flags, "--count", "8"]) == 0
    assert bench([*flags, "--count", "16", "--resume", "--json", str(tmp_path / "r.json")]) == 0

    assert asked == [(900_007, 4), (900_008, 4), (900_009, 4), (900_010, 4)]
    document = json.loads((tmp_path / "r.json").read_text())
    assert (document["benchmark"], document["seed"]) == ("perception", 7)
    times = {r["metric"]: r for r in document["rows"] if r["metric"].startswith("time")}
    assert times["time_median"]["n"] == 16
    assert (times["time_median"]["value"], times["time_again_median"]["value"]) == (5.0, 2.0)
    assert "| point error median [mm] | 1 | 1 |" in capsys.readouterr().out
    with pytest.raises(ConfigError, match="answers"):
        bench([*flags, "--pixels", "5", "--resume"])
