"""A training of outlines, from pictures to a checkpoint that draws them."""

from pathlib import Path
from typing import Any

import numpy as np
from msgspec import structs

from w2c_grounding.card import ModelCard, write_card
from w2c_grounding.family import Family
from w2c_grounding.model_config import ModelConfig
from w2c_grounding.outline import weights
from w2c_grounding.outline.draws_outlines import DrawsOutlines
from w2c_grounding.outline.network import OutlineNetwork
from w2c_grounding.registry import load
from w2c_grounding.sizes import OTHERS
from w2c_grounding.train.addition.run import Material
from w2c_grounding.train.outline.overlap import overlaps
from w2c_grounding.train.outline.samples import collect, lit
from w2c_grounding.train.outline.trainer import OutlineTrainer

MOST_PICTURES = 4000
"""That are asked: each takes 0.1 s on two cores, and what it lights 0.4 MB"""
JUDGED_PICTURES = 150
"""Of those kept back"""


class OutlineAddition:
    """Outlines on their way into a checkpoint."""

    def __init__(self, material: Material) -> None:
        """Ask the checkpoint about the pictures. Raises ConfigError, ModelError."""
        self._material = material
        task, card = material.task, material.card
        self._least = OTHERS * card.threshold
        self._family = without_outlines(task.checkpoint, task.threads)
        some = material.used[:: -(-len(material.used) // MOST_PICTURES)]
        material.report(f"asking the checkpoint about {len(some)} pictures")
        squares = collect(self._family, some, self._least, card.edge, task.seed, material.report)
        self._network = weights.read(task.checkpoint) if card.outlines else OutlineNetwork()
        self._count = len(squares)
        self.trainer = OutlineTrainer(
            self._network, squares, material.plan, material.clock, material.started_ns
        )

    def finish(self, checkpoint: Path) -> dict[str, float]:
        """Write network and card, and return how well boxes fit. Raises ConfigError."""
        task, card = self._material.task, self._material.card
        weights.write(self._network.eval(), checkpoint)
        write_card(structs.replace(card, outlines=True), checkpoint)
        drawing = DrawsOutlines(self._family, weights.read(checkpoint), self._least, edge=card.edge)
        kept = self._material.kept
        shown = (
            one
            for number, path in enumerate(kept[:: max(1, len(kept) // JUDGED_PICTURES)])
            for one in lit(
                self._family,
                path,
                self._least,
                card.edge,
                np.random.default_rng([task.seed, 10, number]),
            )
        )
        scores = overlaps(shown, drawing, self._least, card.edge)
        return {**scores, "squares": float(self._count)}


def without_outlines(checkpoint: Path, threads: int) -> Family[Any]:
    """Return a checkpoint as it lights what is found, and large and small alike."""

    def plain(card: ModelCard) -> ModelCard:
        return structs.replace(card, outlines=False, compares_sizes=False)

    return load(ModelConfig(model=str(checkpoint), threads=threads), plain)[0]
