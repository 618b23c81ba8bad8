"""The training loop: questions about pictures, for as long as it is given."""

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch

from w2c.errors import ConfigError
from w2c_grounding.train.augment import normalise, vary
from w2c_grounding.train.data import Pictures
from w2c_grounding.train.loss import mask_loss, patch_loss, patch_targets
from w2c_grounding.train.model import Size, embed, features
from w2c_grounding.train.phrases import COLOUR_WORDS, Asker, Question

AVERAGING = 0.995
"""Share of the old in the running average of the weights. The average, not the last step, is what
is kept: at any time of the training it is better than the weights themselves."""
DENSE_WEIGHT = 0.4
"""Of what every patch shows, beside what was asked for"""
MIN_PIXELS = 12
"""Of the squashed picture: a thing that a crop leaves less of is not asked for"""


@dataclass(frozen=True)
class Plan:
    """How to train."""

    minutes: float
    """Of processor time, earlier parts that this one continues included: on a loaded machine
    the same training, later"""
    seed: int = 0
    batch: int = 16
    present: int = 3
    """Phrases per picture that fit something"""
    absent: int = 1
    """Phrases per picture that fit nothing"""
    rate: float = 1.0e-3
    """Highest learning rate"""
    weight_decay: float = 0.05
    save_every: float = 60.0
    """[s]"""
    favourites: tuple[str, ...] = ("book", "mug")
    """Kinds that are asked for more often, see `Asker`"""


class Trainer:
    """Model, optimiser, average and clock of one training."""

    def __init__(
        self, model: Any, processor: Any, pictures: Pictures, size: Size, plan: Plan
    ) -> None:
        # On a CPU the fused attention is slower than the plain one, backwards above all.
        model.set_attn_implementation("eager")
        self.model = model
        self._processor = processor
        self._pictures = pictures
        self._size = size
        self._plan = plan
        self._asker = Asker(pictures.truths, frozenset(plan.favourites))
        self._kinds = sorted({item.kind for truth in pictures.truths for item in truth.objects})
        # Every patch learns what it shows, whatever the phrase. Thrown away afterwards; it
        # teaches the picture tower about all objects of a picture at once instead of those asked
        # for.
        self._patch_head = torch.nn.Linear(size.width, len(self._kinds) + len(COLOUR_WORDS))
        self._optimiser = torch.optim.AdamW(
            [*model.parameters(), *self._patch_head.parameters()],
            lr=plan.rate,
            betas=(0.9, 0.98),
            weight_decay=plan.weight_decay,
        )
        self._average = {name: value.clone() for name, value in model.state_dict().items()}
        self._classes = [self._class_table(index) for index in range(len(pictures))]
        self.seconds = 0.0
        self.steps = 0

    def run(self, state: Path, report: Callable[[str], None]) -> None:
        """Train until the time of the plan is used up; saves the state now and then."""
        rng = np.random.default_rng([self._plan.seed, self.steps])
        generator = torch.Generator().manual_seed(int(rng.integers(2**31)))
        started, before = time.process_time(), self.seconds
        saved, reported = time.monotonic(), time.monotonic()
        losses: list[float] = []
        for indices in self._batches(rng):
            self.seconds = before + time.process_time() - started
            if self.seconds >= 60.0 * self._plan.minutes:
                break
            losses.append(self._step(indices, rng, generator))
            now = time.monotonic()
            if now - reported > 15.0:
                report(
                    f"{self.seconds / 60:.1f} min, step {self.steps}, "
                    f"loss {np.mean(losses[-50:]):.4f}, {self.steps * self._plan.batch} pictures"
                )
                reported = now
            if now - saved > self._plan.save_every:
                self.save(state)
                saved = now
        self.save(state)

    def averaged(self) -> Any:
        """Return a copy of the model with the averaged weights."""
        copy = type(self.model)(self.model.config)
        copy.load_state_dict(self._average)
        return copy

    def save(self, path: Path) -> None:
        """Write everything that a continuation needs, so that a crash never leaves half a file."""
        temporary = path.with_suffix(".tmp")
        torch.save(
            {
                "model": self.model.state_dict(),
                "average": self._average,
                "patch_head": self._patch_head.state_dict(),
                "optimiser": self._optimiser.state_dict(),
                "kinds": self._kinds,
                "seconds": self.seconds,
                "steps": self.steps,
            },
            temporary,
        )
        temporary.replace(path)

    def resume(self, path: Path) -> None:
        """Continue from a saved state. Raises ConfigError where it does not fit."""
        try:
            state = torch.load(path, weights_only=True)
            if state["kinds"] != self._kinds:
                raise ConfigError(f"{path} was trained on other kinds of objects; train anew")
            self.model.load_state_dict(state["model"])
            self._patch_head.load_state_dict(state["patch_head"])
            self._optimiser.load_state_dict(state["optimiser"])
        except (OSError, KeyError, RuntimeError, ValueError) as error:
            raise ConfigError(
                f"{path} cannot be continued: {error}; train without --resume"
            ) from error
        self._average = state["average"]
        self.seconds, self.steps = float(state["seconds"]), int(state["steps"])

    def _batches(self, rng: np.random.Generator) -> Iterator[list[int]]:
        """Yield indices of pictures for ever, each picture once a round."""
        waiting: list[int] = []
        while True:
            while len(waiting) < self._plan.batch:
                waiting += [int(index) for index in rng.permutation(len(self._pictures))]
            yield waiting[: self._plan.batch]
            del waiting[: self._plan.batch]

    def _step(
        self, indices: list[int], rng: np.random.Generator, generator: torch.Generator
    ) -> float:
        """Take one step on a batch of pictures; returns the loss."""
        for group in self._optimiser.param_groups:
            group["lr"] = self._rate()
        pixels, owners = self._batch(indices, generator)
        questions = [
            question
            for index in indices
            for question in self._asker.ask(
                self._pictures.truths[index], self._plan.present, self._plan.absent, rng
            )
        ]
        self.model.train()
        # Half the time of single precision on processors with AVX512-BF16.
        with torch.autocast("cpu", torch.bfloat16):
            logits, patches = self._forward(pixels, [question.phrase for question in questions])
        shares = patch_targets(owners, self._class_tables(indices), self._size.patch)
        patches = patches.float()
        kinds = len(self._kinds)
        dense = patch_loss(patches[..., :kinds], shares[..., :kinds]) + patch_loss(
            patches[..., kinds:], shares[..., kinds:]
        )
        # Every second row and column, which ones by chance: the same on average, at a quarter of
        # the time.
        row, column = (int(value) for value in rng.integers(0, 2, 2))
        part = np.s_[:, row::2, column::2]
        loss = self._mask_loss(logits[part].float(), owners[part], questions) + DENSE_WEIGHT * dense
        self._optimiser.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        torch.nn.utils.clip_grad_norm_(self.model.parameters(), 1.0)
        self._optimiser.step()
        self._update_average()
        self.steps += 1
        return float(loss.detach())

    def _forward(
        self, pixels: torch.Tensor, phrases: list[str]
    ) -> tuple[torch.Tensor, torch.Tensor]:
        """Return logits (phrases, side, side) and what each patch shows (n, patches, classes).

        The phrases are those of the first picture, then those of the second ..., equally many.
        """
        seen = features(self.model, normalise(pixels))
        tokens = self._processor.tokenizer(
            phrases,
            padding=True,
            truncation=True,
            max_length=self._size.longest_phrase,
            return_tensors="pt",
        )
        each = len(phrases) // len(pixels)
        repeated = tuple(layer.repeat_interleave(each, dim=0) for layer in seen)
        logits = self.model.decoder(repeated, embed(self.model, tokens)).logits
        return logits, self._patch_head(seen[-1][:, 1:])

    def _mask_loss(
        self, logits: torch.Tensor, owners: torch.Tensor, questions: list[Question]
    ) -> torch.Tensor:
        """Return the loss of heatmaps (phrases, h, w) where pixels have these owners."""
        each = len(questions) // len(owners)
        asked_for = torch.zeros(len(questions), 256, dtype=torch.bool)
        for number, question in enumerate(questions):
            asked_for[number, list(question.identities)] = True
        flat = owners.flatten(1).long().repeat_interleave(each, dim=0)
        masks = asked_for.gather(1, flat).view(logits.shape).float()
        areas = masks.sum(dim=(1, 2))
        weights = ((areas == 0) | (areas >= MIN_PIXELS / 4)).float()
        return mask_loss(logits, masks, weights)

    def _class_tables(self, indices: list[int]) -> torch.Tensor:
        return torch.stack([self._classes[index] for index in indices])

    def _batch(
        self, indices: list[int], generator: torch.Generator
    ) -> tuple[torch.Tensor, torch.Tensor]:
        pixels = torch.from_numpy(self._pictures.pixels[indices]).permute(0, 3, 1, 2)
        owners = torch.from_numpy(self._pictures.identities[indices])
        return vary(pixels.float() / 255.0, owners, generator)

    def _rate(self) -> float:
        """Return the learning rate: a short rise, then half a cosine down over the plan."""
        progress = min(1.0, self.seconds / (60.0 * self._plan.minutes))
        rise = min(1.0, (self.steps + 1) / 100)
        return self._plan.rate * rise * (0.02 + 0.98 * 0.5 * (1.0 + math.cos(math.pi * progress)))

    def _update_average(self) -> None:
        # Early weights are forgotten faster: the average must not lag behind in a short training.
        keep = min(AVERAGING, (1.0 + self.steps) / (10.0 + self.steps))
        with torch.no_grad():
            for name, value in self.model.state_dict().items():
                if value.dtype.is_floating_point:
                    self._average[name].lerp_(value, 1.0 - keep)

    def _class_table(self, index: int) -> torch.Tensor:
        """Return (256, classes): which kind and which colour the object of an id has."""
        colours = sorted(COLOUR_WORDS)
        table = torch.zeros(256, len(self._kinds) + len(colours))
        for item in self._pictures.truths[index].objects:
            table[item.id, self._kinds.index(item.kind)] = 1.0
            if item.colour in COLOUR_WORDS:
                table[item.id, len(self._kinds) + colours.index(item.colour)] = 1.0
        return table
