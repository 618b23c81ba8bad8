"""The training loop of outlines."""

from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from torch.nn import functional

from w2c.clock import Clock
from w2c.errors import ConfigError
from w2c_grounding.outline.network import LAYERS, SIDE, OutlineNetwork
from w2c_grounding.train.loop import TrainingLoop
from w2c_grounding.train.near_views import cut_otherwise, lit_otherwise
from w2c_grounding.train.outline.samples import STORED
from w2c_grounding.train.plan import Plan, learning_rate

OF_A_STEP = 64
"""Squares"""
SCALES = (0.75, 1.2)
"""Of the side that is cut, from one square to the other"""
SHIFT = 0.15
"""Of the middle, at most, in halves of the side that was cut out"""


class OutlineTrainer(TrainingLoop):
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
        super().__init__(plan, clock, started_ns)
        self.network = network.train().to(memory_format=torch.channels_last)  # type: ignore[call-overload]
        self._squares = squares
        self._optimizer = torch.optim.AdamW(network.parameters(), weight_decay=plan.weight_decay)

    def step(self) -> float:
        """Take one step; returns the loss.

        Raises:
            ModelError: gradients are not finite.
        """
        read, thing = self._batch()
        with torch.autocast("cpu", torch.bfloat16, enabled=self._plan.bf16):
            logits = self.network(read.contiguous(memory_format=torch.channels_last))
        loss = outline_loss(logits.float(), thing)
        rate = learning_rate(self._plan, self.progress)
        for group in self._optimizer.param_groups:
            group["lr"] = rate
        self._optimizer.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        norm = torch.nn.utils.clip_grad_norm_(self.network.parameters(), 1.0)
        if not bool(torch.isfinite(norm)):
            # None is let pass: the norms' running means have seen what led to it.
            self.skip(rate, most=0)
        self._optimizer.step()
        self.progress.steps += 1
        return float(loss.detach())

    def _batch(self) -> tuple[torch.Tensor, torch.Tensor]:
        """Return what the network reads, and where the things are (n, SIDE, SIDE), 0 to 1."""
        rng = np.random.default_rng([self._plan.seed, 9, self.progress.steps])
        chosen = rng.integers(len(self._squares), size=OF_A_STEP)
        generator = torch.Generator().manual_seed(int(rng.integers(2**31)))
        stored = torch.from_numpy(self._squares[chosen]).permute(0, 3, 1, 2).float() / 255.0
        seen = cut_otherwise(stored, SIDE, SIDE / STORED, SCALES, SHIFT, generator)
        read = torch.cat([lit_otherwise(seen[:, :3], generator), seen[:, 3:LAYERS]], dim=1)
        return read, seen[:, LAYERS]

    def state(self) -> dict[str, Any]:
        """Return what a continuation needs."""
        return {
            "network": self.network.state_dict(),
            "optimizer": self._optimizer.state_dict(),
            "progress": vars(self.progress).copy(),
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Continue from a saved state. Raises ConfigError where it does not fit."""
        try:
            self.network.load_state_dict(state["network"])
            self._optimizer.load_state_dict(state["optimizer"])
            self.go_on_from(state["progress"])
        except (KeyError, RuntimeError, ValueError, TypeError) as error:
            raise ConfigError(
                f"the state is of another training: {error}; train without --resume"
            ) from error


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
