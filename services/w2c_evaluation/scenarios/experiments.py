"""The paper's four experiments: how a layout of each is drawn, and where its places may lie.

What is said in them, and the places that are meant, stand in their scenes.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from w2c.errors import ConfigError
from w2c.library import library
from w2c_evaluation.demo.layout import draw_layout
from w2c_evaluation.scenarios.scenario import Scenario, Vector3, read_scenario


def _with_reach(seed: int, scene_path: Path) -> str:
    """Draw (a) so that the cup is out of reach on two feet and within reach with the support."""
    return str(draw_layout(seed, scene_path))


def _named(scene: str) -> Callable[[int, Path], str]:
    def draw(seed: int, scene_path: Path) -> str:
        library("save_scene")(library("named_scene")(scene, seed), scene_path)
        return f"{scene}, as it comes from its seed"

    return draw


@dataclass(frozen=True)
class Experiment:
    """One of them."""

    name: str
    title: str
    draw_layout: Callable[[int, Path], str] = field(repr=False)
    """Writes the scene file of a seed and says it for a log. Raises ConfigError."""
    spreads: tuple[Vector3, ...] = ()
    """How far the place of each prompt may differ, in shares of the thing's size"""

    def read(self, scene_path: Path) -> Scenario:
        """Return the prompts and places of a layout. Raises ConfigError."""
        return read_scenario(self.name, scene_path, self.spreads)


EXPERIMENTS: dict[str, Experiment] = {
    one.name: one
    for one in (
        Experiment("a", "book and cup on a table", _with_reach, ((0.12, 0.12, 0.0),)),
        Experiment("b", "white surface and dishwasher", _named("scenario_b"), ((0.08, 0.06, 0.0),)),
        Experiment("c", "mallet and nail box on a table", _named("scenario_c")),
        Experiment("d", "cloth over a fridge", _named("scenario_d"), ((0.08, 0.12, 0.0),)),
    )
}


def find_experiment(name: str) -> Experiment:
    """Return an experiment. Raises ConfigError."""
    if name not in EXPERIMENTS:
        raise ConfigError(f"no scenario '{name}'; choose of: {', '.join(EXPERIMENTS)}")
    return EXPERIMENTS[name]
