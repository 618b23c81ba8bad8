"""A training of the network of things, from pictures to a checkpoint that finds them."""

from pathlib import Path
from typing import Any

from msgspec import structs

from w2c.errors import ConfigError
from w2c_grounding.card import ModelCard
from w2c_grounding.family import Family
from w2c_grounding.model_config import ModelConfig
from w2c_grounding.registry import load
from w2c_grounding.things import weights
from w2c_grounding.things.finder import ThingFinder
from w2c_grounding.things.network import ThingsNetwork
from w2c_grounding.train.addition.run import Material
from w2c_grounding.train.measure import CALIBRATION_PICTURES, measured
from w2c_grounding.train.model import read
from w2c_grounding.train.pictures import open_pictures
from w2c_grounding.train.things.recall import recall
from w2c_grounding.train.things.trainer import ThingsTrainer


class ThingsAddition:
    """The network of things on its way into a checkpoint."""

    def __init__(self, material: Material) -> None:
        """Read the pictures. Raises ConfigError."""
        self._material = material
        task = material.task
        if not material.card.second_look:
            raise ConfigError(
                f"{task.checkpoint} has no second look, and nothing else asks what things are: "
                "first give it one with: w2c train second-look"
            )
        model, _, size = read(task.checkpoint)
        material.report("reading them")
        pictures = open_pictures(material.used, size.image, task.out / "pictures", task.threads)
        if material.card.things:
            self._network = weights.read(task.checkpoint)
        else:
            self._network = ThingsNetwork(size.width * len(size.extract))
        self.trainer = ThingsTrainer(
            self._network,
            model,
            size,
            pictures,
            material.plan,
            material.clock,
            material.started_ns,
        )

    def finish(self, checkpoint: Path) -> dict[str, float]:
        """Write network and card, and return the scores. Raises ConfigError, ModelError."""
        weights.write(self._network.eval(), checkpoint)
        task, kept = self._material.task, self._material.kept
        card = structs.replace(self._material.card, things=True)
        scores = measured(card, kept, checkpoint, seed=task.seed, threads=task.threads)
        some = kept[:: max(1, len(kept) // CALIBRATION_PICTURES)]
        finder = ThingFinder(weights.read(checkpoint))
        return {**scores, **recall(as_it_sees(checkpoint, task.threads), finder, some)}


def as_it_sees(checkpoint: Path, threads: int) -> Family[Any]:
    """Return a checkpoint's own family, without what was added to it."""

    def plain(card: ModelCard) -> ModelCard:
        return structs.replace(
            card, second_look=False, things=False, outlines=False, compares_sizes=False
        )

    return load(ModelConfig(model=str(checkpoint), threads=threads), plain)[0]
