"""Which scene `w2c up` gives to robot and camera."""

from pathlib import Path

import pytest

from w2c.errors import ConfigError
from w2c_launcher.profiles import Options
from w2c_launcher.up import UpConfig, options_of, with_scene
from w2c_sim_robot.scenes.named import named_scene
from w2c_sim_robot.scenes.scene import load


def options(scene: str, directory: Path, seed: int = 0) -> Options:
    return with_scene(
        options_of(UpConfig(scene=scene, seed=seed, private=True), directory), "simulation"
    )


def test_without_a_scene_it_is_that_of_the_demo(tmp_path: Path) -> None:
    assert load(Path(options("", tmp_path, seed=4).scene)) == named_scene("scenario_a", 0)


def test_a_name_is_drawn_from_the_seed(tmp_path: Path) -> None:
    assert load(Path(options("scenario_b", tmp_path, seed=4).scene)) == named_scene("scenario_b", 4)


def test_a_file_is_taken_as_it_is(tmp_path: Path) -> None:
    assert options("elsewhere/scene.json", tmp_path).scene.endswith("/elsewhere/scene.json")


def test_neither_file_nor_name_is_answered_with_the_names(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="no scene 'kitchen'; choose of: scenario_a, scenario_b"):
        options("kitchen", tmp_path)
