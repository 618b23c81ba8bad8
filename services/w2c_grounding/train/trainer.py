"""The training loop: questions about pictures, until the time or the steps are spent.

Every step is a function of the seed and its number, and there is no dropout, so a training that was
interrupted does what it would have done.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import torch

from w2c.clock import Clock
from w2c.errors import ConfigError, W2CError
from w2c_grounding.train.asker import Asker, Question
from w2c_grounding.train.augment import normalise
from w2c_grounding.train.batch import Batch, Batches
from w2c_grounding.train.classes import Classes
from w2c_grounding.train.data import ROBOT
from w2c_grounding.train.loop import TrainingLoop
from w2c_grounding.train.loss import mask_loss
from w2c_grounding.train.model import Size, decode, embed, features, quieten
from w2c_grounding.train.optimizer import Optimizer
from w2c_grounding.train.pictures import Pictures
from w2c_grounding.train.plan import Plan, learning_rate

AVERAGING = 0.997
"""Share of the old in the running average of the weights. The average, not the last step, is what
is kept: at any time of the training it is better than the weights themselves."""
PATCH_WEIGHT = 0.6
"""Of what every patch shows, beside what was asked for; falls to a third until the end"""
LEAST_AREA = 24
"""Of what a phrase fits [px of every second row and column]: where less of it is seen, a heatmap is
judged neither for nor against it"""


class Trainer(TrainingLoop):
    """Model, optimiser, average and clock of one training."""

    def __init__(
        self,
        model: Any,
        processor: Any,
        pictures: Pictures,
        size: Size,
        plan: Plan,
        clock: Clock,
        started_ns: int,
    ) -> None:
        """`pictures` are those to train on; `started_ns` is when the command began."""
        _choose_attention(model, bf16=plan.bf16)
        super().__init__(plan, clock, started_ns)
        self.model = model.train()
        self._processor = processor
        self._size = size
        self._batches = Batches(pictures, size, plan, Asker(pictures.truths))
        self._classes = Classes(pictures.truths)
        self._head = self._classes.head(size.width)
        # Without gradients no step of it is kept for going back: that is half of the time.
        model.clip.vision_model.requires_grad_(not plan.words_only)
        named = [*model.named_parameters(), *self._head.named_parameters()]
        self._optimizer = Optimizer(
            [(name, weight) for name, weight in named if weight.requires_grad],
            plan.weight_decay,
            bf16=plan.bf16,
        )
        self._average = {name: value.clone() for name, value in model.state_dict().items()}
        self._loudness: list[torch.Tensor] = []

    def step(self) -> float:
        """Take one step; returns the loss.

        Raises:
            ModelError: gradients are not finite, again and again.
        """
        rate = learning_rate(self._plan, self.progress)
        loss = self._loss(self._batches.make(self.progress))
        loss.backward()  # type: ignore[no-untyped-call]
        weights = [*self.model.parameters(), *self._head.parameters()]
        norm = torch.nn.utils.clip_grad_norm_(weights, 1.0)
        if not bool(torch.isfinite(norm)):
            self.model.zero_grad()
            self._head.zero_grad()
            self.skip(rate)
        else:
            self._optimizer.step(rate)
            quieten(self.model, [float(one) for one in self._loudness])
            self._update_average()
        self.progress.steps += 1
        return float(loss.detach())

    def averaged(self) -> Any:
        """Return a copy of the model with the averaged weights."""
        copy = type(self.model)(self.model.config)
        copy.load_state_dict(self._average)
        return copy.eval()

    def state(self) -> dict[str, Any]:
        """Return what a continuation needs."""
        return {
            "model": self.model.state_dict(),
            "average": self._average,
            "head": self._head.state_dict(),
            "optimizer": self._optimizer.state_dict(),
            "progress": vars(self.progress).copy(),
        }

    def load(self, state: Mapping[str, Any]) -> None:
        """Take weights, average and the optimiser's memory from a saved state."""
        self.model.load_state_dict(state["model"])
        self._head.load_state_dict(state["head"])
        self._optimizer.load_state_dict(state["optimizer"])
        self._average = {name: value.clone() for name, value in state["average"].items()}

    def _loss(self, batch: Batch) -> torch.Tensor:
        row, column = (self.progress.steps // 2) % 2, self.progress.steps % 2
        with torch.autocast("cpu", torch.bfloat16, enabled=self._plan.bf16):
            seen = features(self.model, normalise(batch.pixels), batch.corners)
            tokens = self._processor.tokenizer(
                [question.phrase for question in batch.questions],
                padding=True,
                truncation=True,
                max_length=self._size.longest_phrase,
                return_tensors="pt",
            )
            # Every second row and column of the heatmaps, others in each step: the same on average,
            # at a quarter of the time.
            self._loudness.clear()
            conditions = embed(self.model, tokens)
            logits = decode(self.model, seen, conditions, (row, column), 2, self._loudness)
            patches = self._head(seen[-1][:, 1:])
        asked = _mask_loss(
            logits.float(), batch.owners[:, row::2, column::2], batch.questions, LEAST_AREA
        )
        if self._plan.words_only:
            return asked
        dense = self._classes.loss(patches.float(), batch.owners, batch.truths, self._size.patch)
        share = 1.0 - self.progress.fraction(self._plan) * 2.0 / 3.0
        return asked + PATCH_WEIGHT * share * dense

    def _update_average(self) -> None:
        # Early weights are forgotten faster: the average must not lag behind in a short training.
        keep = min(AVERAGING, (1.0 + self.progress.steps) / (10.0 + self.progress.steps))
        with torch.no_grad():
            for name, value in self.model.state_dict().items():
                if value.dtype.is_floating_point:
                    self._average[name].lerp_(value, 1.0 - keep)


def _choose_attention(model: Any, *, bf16: bool) -> None:
    """In bfloat16 PyTorch's fused attention goes back three times as slowly as its parts do."""
    attention = "eager" if bf16 else "sdpa"
    model.set_attn_implementation(attention)
    for layer in model.decoder.layers:  # which have a configuration of their own
        layer.self_attn.config._attn_implementation = attention


def _mask_loss(
    logits: torch.Tensor, owners: torch.Tensor, questions: Sequence[Question], least_area: int
) -> torch.Tensor:
    """Return the loss of heatmaps (phrases, h, w) where pixels have these owners (n, h, w)."""
    each = len(questions) // len(owners)
    asked_for = torch.zeros(len(questions), 256, dtype=torch.bool)
    for number, question in enumerate(questions):
        asked_for[number, list(question.identities)] = True
    asked_for[:, ROBOT] = False
    flat = owners.flatten(1).long().repeat_interleave(each, dim=0)
    pixels = torch.zeros(asked_for.shape).scatter_add_(1, flat, torch.ones(flat.shape))
    pixels *= asked_for
    areas = pixels.sum(dim=1)
    # A thing of which next to nothing shows counts by what shows.
    shares = (asked_for / pixels.clamp(min=least_area)).gather(1, flat).view(logits.shape)
    return mask_loss(logits, shares, ((areas == 0) | (areas >= least_area)).float())


def save_state(state: dict[str, Any], path: Path) -> None:
    """Write a checkpoint, whole or not at all. Raises W2CError where the disk is full."""
    unfinished = path.with_suffix(".unfinished")
    try:
        # To an open file: given a path, torch raises a RuntimeError for a full disk.
        with unfinished.open("wb") as file:
            torch.save(state, file)
        unfinished.replace(path)
    except OSError as error:
        unfinished.unlink(missing_ok=True)
        raise W2CError(f"{path} was not written: {error}; free some space") from error


def read_state(path: Path, identity: dict[str, str]) -> dict[str, Any]:
    """Return a checkpoint of a training with this identity. Raises ConfigError."""
    try:
        state: dict[str, Any] = torch.load(path, weights_only=True)
        found = state["identity"]
    except Exception as error:  # of pickle, zip, torch or the file system
        raise ConfigError(f"{path} cannot be continued: {error}; train without --resume") from error
    other = [
        f"{name} was {found.get(name)}, now {value}"
        for name, value in identity.items()
        if found.get(name) != value
    ]
    if other:
        raise ConfigError(
            f"{path} is of another training: {'; '.join(other)}. Use what it began with, or "
            "train without --resume"
        )
    return state
