"""A training of the second look, from pictures to a checkpoint that has one."""

from pathlib import Path

from msgspec import structs

from w2c_grounding.second_look import weights
from w2c_grounding.second_look.network import SecondLookNetwork, with_words
from w2c_grounding.train.addition.run import Material
from w2c_grounding.train.measure import measured
from w2c_grounding.train.second_look.squares import cut_out
from w2c_grounding.train.second_look.trainer import SecondLookTrainer
from w2c_grounding.train.vocabulary import vocabulary_of


class SecondLookAddition:
    """A second look on its way into a checkpoint."""

    def __init__(self, material: Material) -> None:
        """Cut out the things of the pictures. Raises ConfigError."""
        self._material = material
        task = material.task
        material.report("cutting out their things")
        squares = cut_out(material.used, task.seed, task.threads)
        vocabulary = vocabulary_of(squares.truths)
        if material.card.second_look:
            self._network = with_words(weights.read(task.checkpoint), vocabulary)
        else:
            self._network = SecondLookNetwork(vocabulary)
        self._count = len(squares.cuts)
        self.trainer = SecondLookTrainer(
            self._network, squares, material.plan, material.clock, material.started_ns
        )

    def finish(self, checkpoint: Path) -> dict[str, float]:
        """Write network and card, and return the scores. Raises ConfigError, ModelError."""
        weights.write(self._network.eval(), checkpoint)
        card = structs.replace(self._material.card, second_look=True)
        task, kept = self._material.task, self._material.kept
        scores = measured(card, kept, checkpoint, seed=task.seed, threads=task.threads)
        return {**scores, "squares": float(self._count)}
