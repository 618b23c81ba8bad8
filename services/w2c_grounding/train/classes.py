"""What each patch shows, learned beside the phrases: kind, colour and material of its object.

The classifier is thrown away afterwards. It teaches the picture tower about all objects of a
picture in every step, instead of those that were asked for.
"""

from collections.abc import Iterable, Sequence

import torch

from w2c_grounding.train.data import PictureTruth
from w2c_grounding.train.loss import patch_loss, patch_targets

WEIGHTS = {"kind": 0.6, "colour": 0.2, "material": 0.2}
"""Of the three losses: kinds are by far the hardest"""


class Classes:
    """All kinds, colours and materials of a set of pictures, one after another."""

    def __init__(self, truths: Iterable[PictureTruth]) -> None:
        found: dict[str, set[str]] = {name: set() for name in WEIGHTS}
        for truth in truths:
            for item in truth.objects:
                for name in WEIGHTS:
                    value = getattr(item, name)
                    if value:
                        found[name].add(value)
        self.names = {name: tuple(sorted(values)) for name, values in found.items()}
        self._column: dict[tuple[str, str], int] = {}
        for name, values in self.names.items():
            for value in values:
                self._column[name, value] = len(self._column)

    def __len__(self) -> int:
        """Return how many there are, of all three."""
        return len(self._column)

    def head(self, width: int) -> torch.nn.Module:
        """Return the classifier of activations of this width."""
        last = torch.nn.Linear(width, len(self))
        torch.nn.init.zeros_(last.weight)
        torch.nn.init.zeros_(last.bias)
        return torch.nn.Sequential(torch.nn.LayerNorm(width), last)

    def table(self, truths: Sequence[PictureTruth]) -> torch.Tensor:
        """Return (n, 256, classes) 0 or 1: which classes the object of an id belongs to."""
        table = torch.zeros(len(truths), 256, len(self))
        for index, truth in enumerate(truths):
            for item in truth.objects:
                for name in WEIGHTS:
                    column = self._column.get((name, getattr(item, name)))
                    if column is not None:
                        table[index, item.id, column] = 1.0
        return table

    def loss(
        self,
        logits: torch.Tensor,
        owners: torch.Tensor,
        truths: Sequence[PictureTruth],
        patch: int,
    ) -> torch.Tensor:
        """Return the loss of logits (n, patches, classes) where pixels have these owners."""
        shares = patch_targets(owners, self.table(truths), patch)
        total = torch.zeros(())
        first = 0
        for name, weight in WEIGHTS.items():
            part = slice(first, first + len(self.names[name]))
            if self.names[name]:
                total = total + weight * patch_loss(logits[..., part], shares[..., part])
            first = part.stop
        return total
