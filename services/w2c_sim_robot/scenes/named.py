"""Scenes by name: what `--scene NAME` and `w2c scenes make` know."""

from collections.abc import Callable

from w2c.errors import ConfigError
from w2c_sim_robot.scenes.random_scene import random_scene
from w2c_sim_robot.scenes.scenario_a import scenario_a
from w2c_sim_robot.scenes.scenario_b import scenario_b
from w2c_sim_robot.scenes.scenario_c import scenario_c
from w2c_sim_robot.scenes.scenario_d import scenario_d
from w2c_sim_robot.scenes.scenario_e import scenario_e
from w2c_sim_robot.scenes.scene import Scene

SCENES: dict[str, Callable[[int], Scene]] = {
    "scenario_a": lambda seed: scenario_a(seed=seed),
    "scenario_b": lambda seed: scenario_b(seed=seed),
    "scenario_c": lambda seed: scenario_c(seed=seed),
    "scenario_d": lambda seed: scenario_d(seed=seed),
    "scenario_e": lambda seed: scenario_e(seed=seed),
    "random": random_scene,
}


def named_scene(name: str, seed: int = 0) -> Scene:
    """Return the scene of this name for a seed. Raises ConfigError with the names there are."""
    if name not in SCENES:
        raise ConfigError(f"no scene '{name}'; choose of: {', '.join(SCENES)}, or give a file")
    return SCENES[name](seed)
