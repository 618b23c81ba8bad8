"""The training loop: one pass over the data after another, until the time or the steps are spent.

The order of the examples is a function of seed and epoch, what dropout leaves out one of seed and
step, so a run that is resumed does what it would have done. The learning rate follows the share of
the budget that is spent: of wall time, which no two runs spend alike, or of steps, which all do.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import torch
from transformers import Qwen2ForCausalLM

from w2c.clock import Clock
from w2c.errors import ModelError
from w2c_llm.train.batches import Batch, Mixture, epoch_groups, make_batch
from w2c_llm.train.device import CPU, Device
from w2c_llm.train.dropout import Dropout
from w2c_llm.train.machine_code import as_machine_code, compiling
from w2c_llm.train.optimizer import Optimizer

_STEPS_OF_A_RISE = 100
"""After a growth, at most; as far as the optimizers' averages reach back"""
_MOST_SKIPPED = 20
"""Steps without a finite gradient, after which something is wrong with rate or data"""


@dataclass(frozen=True)
class Recipe:
    """How to train."""

    minutes: float
    """Wall time of the run, over all resumptions, from its first preparations on"""
    steps: int | None = None
    """Ends after so many steps instead; the schedule counts them, the minutes do not matter"""
    batch: int = 96
    peak_rate: float = 5e-3
    warm_up: float = 0.03
    """Share of the budget in which the learning rate rises"""
    weight_decay: float = 0.05
    prompt_weight: float = 0.0
    """Weight of a token of the prompt in the loss; an answer's token has 1. Without prompts a step
    takes less time, and in a small trial it taught no less."""
    prompt_share: float = 0.6
    """Share of the budget in which prompts count: then the time goes to the answers alone"""
    dropout: float = 0.0
    """Share of what each block adds that is left out"""
    compiled: bool = False
    """Whether the network becomes machine code first"""
    closing_s: float = 60.0
    """Kept back from the minutes for scores and export, at most a tenth of them"""
    seed: int = 0
    report_s: float = 120.0
    """Time between reports"""
    checkpoint_s: float = 240.0
    """Time between checkpoints"""

    @property
    def last_s(self) -> float:
        """Return when the last step is to end."""
        return 60.0 * self.minutes - min(self.closing_s, 6.0 * self.minutes)


@dataclass
class Progress:
    """Where the training is; travels in the checkpoint."""

    step: int = 0
    epoch: int = 0
    batch: int = 0
    """Batches of this epoch that are done"""
    examples: int = 0
    seconds: float = 0.0
    """Wall time since the run's beginning, without what passed between its parts"""
    began: float = 0.0
    """`seconds` at the first step"""
    skipped: int = 0
    """Steps whose gradient was not finite"""
    grown_at: int | None = None
    """Step at which the network got more layers"""

    def fraction(self, recipe: Recipe) -> float:
        """Return how much of the budget is spent, 0 to 1."""
        if recipe.steps is not None:
            return min(self.step / recipe.steps, 1.0)
        length = recipe.last_s - self.began
        return min((self.seconds - self.began) / length, 1.0) if length > 0.0 else 1.0

    def rate(self, recipe: Recipe) -> float:
        """Return the learning rate; after a growth it rises again, for new optimizers' sake."""
        rate = learning_rate(recipe, self.fraction(recipe))
        if self.grown_at is None:
            return rate
        steps = min(_STEPS_OF_A_RISE, 1 + self.grown_at // 4)
        return rate * min((self.step - self.grown_at + 1) / steps, 1.0)


@dataclass(frozen=True)
class Report:
    """What happened since the last report."""

    progress: Progress
    loss: float
    rate: float


@dataclass(frozen=True)
class Listeners:
    """Who is told what while the training goes on."""

    report: Callable[[Report], None]
    checkpoint: Callable[[], None]
    stopped: Callable[[], bool] = lambda: False
    """Asked after every step; True ends the training, to be resumed"""


def learning_rate(recipe: Recipe, fraction: float) -> float:
    """Return the rate at a fraction of the budget: linear warm-up, then a cosine to a fiftieth."""
    if fraction < recipe.warm_up:
        return recipe.peak_rate * max(fraction / recipe.warm_up, 0.02)
    cosine = 0.5 * (1.0 + math.cos(math.pi * (fraction - recipe.warm_up) / (1.0 - recipe.warm_up)))
    return recipe.peak_rate * (0.02 + 0.98 * cosine)


class Trainer:
    """Owns network, optimizer and progress. `started_ns` is when the run began its preparations."""

    def __init__(
        self,
        network: Qwen2ForCausalLM,
        recipe: Recipe,
        clock: Clock,
        started_ns: int,
        device: Device = CPU,
    ) -> None:
        self.network = network
        torch.nn.Module.to(network, device.torch_device)
        self.recipe = recipe
        self.device = device
        self.progress = Progress()
        self._dropout = Dropout(network, recipe.dropout, recipe.seed)
        # The network itself stays as it is, for scores and export: one program less to compile.
        self._body: Callable[..., Any] = network.model
        if recipe.compiled:
            self._body = as_machine_code(network.model)
        self._optimizer = Optimizer(network, recipe.weight_decay, bf16=device.bf16)
        self._clock = clock
        self._started_ns = started_ns
        self._earlier_s = 0.0

    def grown(self, network: Qwen2ForCausalLM) -> "Trainer":
        """Return a trainer of a deeper network that goes on where this one is."""
        other = Trainer(network, self.recipe, self._clock, self._started_ns, self.device)
        other.progress = replace(self.progress, grown_at=self.progress.step)
        other._earlier_s = self._earlier_s
        return other

    def state(self) -> dict[str, Any]:
        """Return what a checkpoint keeps."""
        return {
            "network": self.network.state_dict(),
            "optimizer": self._optimizer.state_dict(),
            "progress": vars(self.progress).copy(),
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Continue from what a checkpoint kept."""
        self.network.load_state_dict(state["network"])
        self._optimizer.load_state_dict(state["optimizer"])
        self.progress = Progress(**state["progress"])
        self._earlier_s = self.progress.seconds

    def train(self, mixture: Mixture, listeners: Listeners, until: float = 1.0) -> bool:
        """Train until this share of the budget is spent; return whether it is.

        Raises:
            ModelError: gradients are not finite, again and again.
        """
        self.network.train()
        if self.recipe.compiled:
            self._compile(mixture)
        self._look_at_clock()
        if self.progress.step == 0:
            self.progress.began = self.progress.seconds
        reported = saved = self.progress.seconds
        losses: list[float] = []
        for batch in self._batches(mixture, until):
            losses.append(self._step(batch))
            seconds = self._look_at_clock()
            if seconds - reported >= self.recipe.report_s:
                listeners.report(self._report(losses))
                reported = seconds
            if seconds - saved >= self.recipe.checkpoint_s:
                listeners.checkpoint()
                saved = seconds
            if listeners.stopped():
                break
        listeners.checkpoint()
        listeners.report(self._report(losses))
        return self.progress.fraction(self.recipe) >= until

    def _compile(self, mixture: Mixture) -> None:
        """Take a step that changes nothing: the rate is not to rise while a compiler works."""
        examples = mixture.examples[: self.recipe.batch]
        with compiling():
            self._find_gradients(make_batch(examples, 0.0, self.device.torch_device))
        self._optimizer.clear()

    def _batches(self, mixture: Mixture, until: float) -> Iterator[Batch]:
        """Yield the batches that are left of this share of the budget, and keep count."""
        while True:
            groups = epoch_groups(mixture, self.recipe.batch, self.recipe.seed, self.progress.epoch)
            while self.progress.batch < len(groups):
                fraction = self.progress.fraction(self.recipe)
                if fraction >= until:
                    return
                prompts = self.recipe.prompt_weight if fraction < self.recipe.prompt_share else 0.0
                examples = [mixture.examples[index] for index in groups[self.progress.batch]]
                self.progress.batch += 1
                yield make_batch(examples, prompts, self.device.torch_device)
            self.progress.epoch += 1
            self.progress.batch = 0

    def _look_at_clock(self) -> float:
        passed_s = (self._clock.now_ns() - self._started_ns) * 1e-9
        self.progress.seconds = self._earlier_s + passed_s
        return self.progress.seconds

    def _report(self, losses: list[float]) -> Report:
        mean = float(np.mean(losses)) if losses else math.nan
        losses.clear()
        return Report(self.progress, mean, self.progress.rate(self.recipe))

    def _step(self, batch: Batch) -> float:
        """Take one step and return the loss."""
        rate = self.progress.rate(self.recipe)
        loss = self._find_gradients(batch)
        norm = torch.nn.utils.clip_grad_norm_(self.network.parameters(), 1.0)
        if bool(torch.isfinite(norm)):
            self._optimizer.step(rate)
        else:
            self._skip(rate)
        self.progress.step += 1
        self.progress.examples += len(batch.tokens)
        return float(loss.detach())

    def _skip(self, rate: float) -> None:
        """Leave the weights as they are. Raises ModelError when that happens too often."""
        self.progress.skipped += 1
        if self.progress.skipped > _MOST_SKIPPED:
            raise ModelError(
                f"no finite gradient in {self.progress.skipped} of {self.progress.step + 1} steps, "
                f"at a learning rate of {rate:.1e}: resume with a lower --rate"
            )

    def _find_gradients(self, batch: Batch) -> torch.Tensor:
        """Put the gradients of a batch in place of those before, and return its loss."""
        self._dropout.begin_step(self.progress.step, len(batch.tokens))
        with self.device.autocast():
            loss = self._weighted_loss(batch)
        self._optimizer.clear()
        torch.autograd.backward(loss)
        return loss

    def _weighted_loss(self, batch: Batch) -> torch.Tensor:
        """Return the mean loss of the tokens that count.

        The output layer sees only positions that count: with a vocabulary wider than the network it
        would be most of the work otherwise.
        """
        chosen = batch.weights.flatten().nonzero().squeeze(1)
        weights = batch.weights.flatten()[chosen]
        hidden = self._body(input_ids=batch.tokens).last_hidden_state.flatten(0, 1)
        losses = torch.nn.functional.cross_entropy(
            self.network.lm_head(hidden.index_select(0, chosen)).float(),
            batch.targets.flatten()[chosen],
            reduction="none",
        )
        return (losses * weights).sum() / weights.sum()
