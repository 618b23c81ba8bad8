"""The training loop of outlines."""

import numpy as np
import numpy.typing as npt
import torch
from torch.nn import functional

from w2c.clock import Clock
from w2c_grounding.outline.network import LAYERS, SIDE, OutlineNetwork
from w2c_grounding.train.addition.trainer import AdditionTrainer
from w2c_grounding.train.near_views import cut_otherwise, lit_otherwise
from w2c_grounding.train.outline.samples import STORED
from w2c_grounding.train.plan import Plan

OF_A_STEP = 64
"""Squares"""
SCALES = (0.75, 1.2)
"""Of the side that is cut, from one square to the other"""
SHIFT = 0.15
"""Of the middle, at most, in halves of the side that was cut out"""
LARGEST_GRADIENT = 1.0
"""Norm"""


class OutlineTrainer(AdditionTrainer):
    """Network, optimiser and clock of one training."""

    def __init__(
        self,
        network: OutlineNetwork,
        squares: npt.NDArray[np.uint8],
        plan: Plan,
        clock: Clock,
        started_ns: int,
    ) -> None:
        """`squares` are those of `collect`; `started_ns` is when the command began."""
        super().__init__(
            {"network": network}, plan, clock, started_ns, largest_gradient=LARGEST_GRADIENT
        )
        self.network = network.train().to(memory_format=torch.channels_last)  # type: ignore[call-overload]
        self._squares = squares

    def loss(self) -> torch.Tensor:
        """Return the loss of the next step."""
        read, thing = self._batch()
        with torch.autocast("cpu", torch.bfloat16, enabled=self._plan.bf16):
            logits = self.network(read.contiguous(memory_format=torch.channels_last))
        return outline_loss(logits.float(), thing)

    def _batch(self) -> tuple[torch.Tensor, torch.Tensor]:
        """Return what the network reads, and where the things are (n, SIDE, SIDE), 0 to 1."""
        rng = np.random.default_rng([self._plan.seed, 9, self.progress.steps])
        chosen = rng.integers(len(self._squares), size=OF_A_STEP)
        generator = torch.Generator().manual_seed(int(rng.integers(2**31)))
        stored = torch.from_numpy(self._squares[chosen]).permute(0, 3, 1, 2).float() / 255.0
        seen = cut_otherwise(stored, SIDE, SIDE / STORED, SCALES, SHIFT, generator)
        read = torch.cat([lit_otherwise(seen[:, :3], generator), seen[:, 3:LAYERS]], dim=1)
        return read, seen[:, LAYERS]


def outline_loss(logits: torch.Tensor, thing: torch.Tensor) -> torch.Tensor:
    """Return the loss of drawings (n, h, w) where the thing covers these shares of pixels.

    Cross-entropy, and one minus the soft overlap (Milletari et al., 3DV 2016, equation 1): a thin
    thing is a small part of its square, and counts as much as a large one.
    """
    each = functional.binary_cross_entropy_with_logits(logits, thing)
    drawn = torch.sigmoid(logits)
    common = (drawn * thing).sum(dim=(1, 2))
    total = (drawn + thing).sum(dim=(1, 2))
    overlap = (2.0 * common + 1.0) / (total + 1.0)
    return each + (1.0 - overlap).mean()
