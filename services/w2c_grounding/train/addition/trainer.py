"""The training loop of what is added: AdamW, and a step that only finite gradients take."""

import math
from abc import abstractmethod
from collections.abc import Mapping
from typing import Any

import torch
from torch import nn

from w2c.clock import Clock
from w2c_grounding.train.loop import TrainingLoop
from w2c_grounding.train.plan import Plan, learning_rate


class AdditionTrainer(TrainingLoop):
    """A training of which a subclass knows the loss."""

    def __init__(
        self,
        parts: Mapping[str, nn.Module],
        plan: Plan,
        clock: Clock,
        started_ns: int,
        *,
        largest_gradient: float = math.inf,
    ) -> None:
        """Begin.

        Args:
            parts: What is trained, by its name in a saved state.
            plan: How.
            clock: Of the wall time.
            started_ns: When the command began.
            largest_gradient: Norm to which gradients are shortened.
        """
        super().__init__(plan, clock, started_ns)
        self._parts = dict(parts)
        self._weights = [weight for part in self._parts.values() for weight in part.parameters()]
        self._optimizer = torch.optim.AdamW(self._weights, weight_decay=plan.weight_decay)
        self._largest_gradient = largest_gradient

    @abstractmethod
    def loss(self) -> torch.Tensor:
        """Return the loss of the next step."""

    def step(self) -> float:
        """Take one step; returns the loss.

        Raises:
            ModelError: gradients are not finite.
        """
        loss = self.loss()
        rate = learning_rate(self._plan, self.progress)
        for group in self._optimizer.param_groups:
            group["lr"] = rate
        self._optimizer.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        norm = nn.utils.clip_grad_norm_(self._weights, self._largest_gradient)
        if not bool(torch.isfinite(norm)):
            # None is let pass: the norms' running means have seen what led to it.
            self.skip(rate, most=0)
        self._optimizer.step()
        self.progress.steps += 1
        return float(loss.detach())

    def state(self) -> dict[str, Any]:
        """Return what a continuation needs."""
        return {
            **{name: part.state_dict() for name, part in self._parts.items()},
            "optimizer": self._optimizer.state_dict(),
            "progress": vars(self.progress).copy(),
        }

    def load(self, state: Mapping[str, Any]) -> None:
        """Take weights and the optimiser's memory from a saved state."""
        for name, part in self._parts.items():
            part.load_state_dict(state[name])
        self._optimizer.load_state_dict(state["optimizer"])
