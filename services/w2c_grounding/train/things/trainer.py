"""The training loop of the network of things."""

from dataclasses import replace
from typing import Any

import torch

from w2c.clock import Clock
from w2c_grounding.things.network import FINER, ThingsNetwork
from w2c_grounding.train.addition.trainer import AdditionTrainer
from w2c_grounding.train.asker import Asker
from w2c_grounding.train.augment import normalise
from w2c_grounding.train.batch import Batches
from w2c_grounding.train.model import Size, features
from w2c_grounding.train.pictures import Pictures
from w2c_grounding.train.plan import Plan
from w2c_grounding.train.things.loss import things_loss
from w2c_grounding.train.things.targets import targets_of

WINDOWS = 34
"""Of a step, in the sense of `Plan`: whole pictures of as many patches"""
LARGEST_GRADIENT = 1.0
"""Norm"""


class ThingsTrainer(AdditionTrainer):
    """Network, optimiser and clock of one training."""

    def __init__(
        self,
        network: ThingsNetwork,
        model: Any,
        size: Size,
        pictures: Pictures,
        plan: Plan,
        clock: Clock,
        started_ns: int,
    ) -> None:
        """`model` sees the pictures, and stays as it is; `started_ns` is when the command began."""
        super().__init__(
            {"network": network}, plan, clock, started_ns, largest_gradient=LARGEST_GRADIENT
        )
        self.network = network.train().to(memory_format=torch.channels_last)  # type: ignore[call-overload]
        self._model = model.eval().requires_grad_(False)
        self._places = FINER * size.cells
        whole = replace(plan, windows=WINDOWS, whole_from=0.0, present=0, absent=0)
        self._batches = Batches(pictures, size, whole, Asker(()))

    def loss(self) -> torch.Tensor:
        """Return the loss of the next step."""
        batch = self._batches.make(self.progress)
        wanted = targets_of(batch.owners.numpy(), batch.truths, self._places)
        pixels = normalise(batch.pixels).contiguous(memory_format=torch.channels_last)
        with torch.autocast("cpu", torch.bfloat16, enabled=self._plan.bf16):
            with torch.no_grad():
                seen = features(self._model, pixels)
            there, fits, boxes = self.network(seen, pixels)
        return things_loss(there.float(), fits.float(), boxes.float(), wanted)
