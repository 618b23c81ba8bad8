"""The training loop: AdamW, cosine schedule over a budget of time or steps, resumable."""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from transformers import Qwen2ForCausalLM

from w2c_llm.train.batches import Batch, shuffled_batches
from w2c_llm.train.tokenizer import EncodedExample


@dataclass(frozen=True)
class Recipe:
    """How to train."""

    minutes: float
    """Wall time in all, over all resumptions; the schedule ends when it is spent"""
    steps: int | None = None
    """Ends earlier, after so many steps; the schedule counts them instead of minutes"""
    batch: int = 48
    peak_rate: float = 2e-3
    warm_up: float = 0.02
    """Share of the budget in which the learning rate rises"""
    weight_decay: float = 0.05
    prompt_weight: float = 0.2
    """Weight of a token of the prompt in the loss; an answer's token has 1"""
    seed: int = 0
    report_every: int = 500
    """Steps between reports, each with a checkpoint"""


@dataclass
class Progress:
    """Where the training is; travels in the checkpoint."""

    step: int = 0
    epoch: int = 0
    examples: int = 0
    seconds: float = 0.0

    def fraction(self, recipe: Recipe) -> float:
        """Return how much of the budget is spent, 0 to 1."""
        if recipe.steps is not None:
            return min(self.step / recipe.steps, 1.0)
        return min(self.seconds / (60.0 * recipe.minutes), 1.0)


@dataclass(frozen=True)
class Report:
    """What happened since the last report."""

    progress: Progress
    loss: float
    rate: float


def learning_rate(recipe: Recipe, fraction: float) -> float:
    """Return the rate at a fraction of the budget: linear warm-up, then a cosine to a fiftieth."""
    if fraction < recipe.warm_up:
        return recipe.peak_rate * max(fraction / recipe.warm_up, 0.02)
    cosine = 0.5 * (1.0 + math.cos(math.pi * (fraction - recipe.warm_up) / (1.0 - recipe.warm_up)))
    return recipe.peak_rate * (0.02 + 0.98 * cosine)


class Trainer:
    """Owns network, optimizer and progress."""

    def __init__(self, network: Qwen2ForCausalLM, recipe: Recipe) -> None:
        self.network = network
        self.recipe = recipe
        self.progress = Progress()
        matrices = [weight for weight in network.parameters() if weight.ndim > 1]
        vectors = [weight for weight in network.parameters() if weight.ndim <= 1]
        self._optimizer = torch.optim.AdamW(
            [
                {"params": matrices, "weight_decay": recipe.weight_decay},
                {"params": vectors, "weight_decay": 0.0},
            ],
            lr=recipe.peak_rate,
            betas=(0.9, 0.98),
        )

    def save(self, path: Path) -> None:
        """Write a checkpoint, whole or not at all."""
        state: dict[str, Any] = {
            "network": self.network.state_dict(),
            "optimizer": self._optimizer.state_dict(),
            "progress": vars(self.progress),
        }
        partial = path.with_suffix(".partial")
        torch.save(state, partial)
        partial.replace(path)

    def restore(self, path: Path) -> None:
        """Continue from a checkpoint."""
        state = torch.load(path, weights_only=True)
        self.network.load_state_dict(state["network"])
        self._optimizer.load_state_dict(state["optimizer"])
        self.progress = Progress(**state["progress"])

    def train(self, examples: Sequence[EncodedExample], report: Callable[[Report], None]) -> None:
        """Train until the budget is spent. `report` is called now and then, and at the end."""
        self.network.train()
        losses: list[float] = []
        while self.progress.fraction(self.recipe) < 1.0:
            # A resumed run draws an order of its own, or it would begin with what it has seen.
            random = np.random.default_rng((self.recipe.seed, self.progress.examples))
            for batch in shuffled_batches(
                examples, self.recipe.batch, self.recipe.prompt_weight, random
            ):
                losses.append(self._step(batch))
                if self.progress.step % self.recipe.report_every == 0:
                    report(self._report(losses))
                if self.progress.fraction(self.recipe) >= 1.0:
                    break
            self.progress.epoch += 1
        report(self._report(losses))

    def _report(self, losses: list[float]) -> Report:
        mean = float(np.mean(losses)) if losses else math.nan
        losses.clear()
        return Report(
            self.progress, mean, learning_rate(self.recipe, self.progress.fraction(self.recipe))
        )

    def _step(self, batch: Batch) -> float:
        """Take one step and return the loss."""
        started = time.monotonic()
        rate = learning_rate(self.recipe, self.progress.fraction(self.recipe))
        for group in self._optimizer.param_groups:
            group["lr"] = rate
        with torch.autocast("cpu", torch.bfloat16):
            loss = _weighted_loss(self.network, batch)
        self._optimizer.zero_grad(set_to_none=True)
        torch.autograd.backward(loss)
        torch.nn.utils.clip_grad_norm_(self.network.parameters(), 1.0)
        self._optimizer.step()
        self.progress.step += 1
        self.progress.examples += len(batch.tokens)
        self.progress.seconds += time.monotonic() - started
        return float(loss.detach())


def _weighted_loss(network: Qwen2ForCausalLM, batch: Batch) -> torch.Tensor:
    """Return the cross entropy, weighted by token.

    The output layer sees only the positions that count: with a vocabulary wider than the network it
    would be most of the work otherwise.
    """
    chosen = batch.weights > 0.0
    weights = batch.weights[chosen]
    hidden = network.model(input_ids=batch.tokens).last_hidden_state[chosen]
    losses = torch.nn.functional.cross_entropy(
        network.lm_head(hidden).float(), batch.targets[chosen], reduction="none"
    )
    return (losses * weights).sum() / weights.sum()
