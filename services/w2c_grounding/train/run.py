"""A training from pictures to a checkpoint with its threshold and its scores."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import torch

from w2c.clock import Clock
from w2c.errors import ConfigError
from w2c_grounding.beside import carried
from w2c_grounding.card import ModelCard, read_card
from w2c_grounding.outline import weights as outline_weights
from w2c_grounding.registry import check_directory
from w2c_grounding.second_look import weights as second_look_weights
from w2c_grounding.things import weights as things_weights
from w2c_grounding.train.augment import normalise
from w2c_grounding.train.data import truth_files
from w2c_grounding.train.growth import resized, with_side, with_words
from w2c_grounding.train.measure import apart, measured, write_scores
from w2c_grounding.train.model import Size, new_model, new_processor, read, save
from w2c_grounding.train.pictures import Pictures, digest, open_pictures
from w2c_grounding.train.plan import NAME, Plan, has_bf16
from w2c_grounding.train.start import start_tower
from w2c_grounding.train.trainer import Trainer, read_state, save_state
from w2c_grounding.train.vocabulary import names_of_size, tokenizer_words, vocabulary_of
from w2c_grounding.train.watch import watch

EDGE = 0.3
"""Where a thing ends in a heatmap of this training: there boxes agree best with those of the truth
(on average .82 of their joint area, at half of the peak .76), and few pairs of things merge"""
FINE_TUNING = 0.35
"""Of the learning rate, where weights are there already"""
START_PICTURES = 48


@dataclass(frozen=True)
class Task:
    """What was asked for; the flags of the command."""

    data: Path
    out: Path
    minutes: float = 60.0
    steps: int = 0
    seed: int = 0
    threads: int = 2
    rate: float | None = None
    begin_with: Path | None = None
    side: int | None = None
    words_only: bool = False
    resume: bool = False
    name: str = NAME
    precision: Literal["auto", "float32", "bfloat16"] = "auto"
    size: Size = field(default_factory=Size)
    plan: Plan = field(default_factory=Plan)
    """Of it only what has no flag counts"""


class Run:
    """One command. `report` takes lines for people."""

    def __init__(self, task: Task, clock: Clock, report: Callable[[str], None]) -> None:
        self._task = task
        self._clock = clock
        self._report = report
        self._started_ns = clock.now_ns()
        self._state = task.out / "state.pt"

    def __call__(self, stopped: Callable[[], bool] = lambda: False) -> dict[str, float] | None:
        """Train, and return the scores on the pictures kept back; None where it was stopped.

        Raises:
            ConfigError: a file is missing or damaged, or does not fit what is to be continued.
            W2CError: the disk is full.
            ModelError: the training fails.
        """
        task = self._task
        torch.set_num_threads(task.threads)
        torch.manual_seed(task.seed)
        files = truth_files(task.data)
        kept, used = apart(files)
        model, processor, size, before = self._begin_with()
        self._report(f"{len(used)} pictures to train on, {len(kept)} kept back; reading them")
        pictures = open_pictures(used, size.image, task.out / "pictures", task.threads)
        watched = open_pictures(kept, size.image, task.out / "pictures" / "kept", task.threads)
        vocabulary = sorted({*(before.vocabulary or ()), *vocabulary_of(pictures.truths)})
        spoken = tokenizer_words(vocabulary)
        if model is None:
            processor = new_processor(size, spoken)
            model = new_model(size, len(processor.tokenizer))
            start_tower(model, size, _some(pictures))
        else:
            model, processor = with_words(model, processor, size, spoken)
        plan = self._plan()
        trainer = Trainer(model, processor, pictures, size, plan, self._clock, self._started_ns)
        identity = {
            "data": digest(files),
            "seed": str(task.seed),
            "begin_with": str(task.begin_with or ""),
            "size": str(size),
            "words_only": str(task.words_only),
        }
        if task.resume:
            trainer.restore(read_state(self._state, identity))

        def keep() -> None:
            save_state({**trainer.state(), "identity": identity}, self._state)
            hits, refused = watch(trainer.averaged(), processor, watched, size, task.seed)
            self._report(f"kept pictures: {hits:.2f} hit, {refused:.2f} of what is absent refused")

        if not trainer.run(keep, self._report, stopped):
            return None
        checkpoint = task.out / "checkpoint"
        card = ModelCard(
            name=task.name,
            edge=EDGE,
            vocabulary=vocabulary,
            compares_sizes=True,
            names_of_size=tuple(sorted({*before.names_of_size, *names_of_size(pictures.truths)})),
            second_look=carried(task.begin_with, checkpoint, second_look_weights.FILE),
            # What finds things reads what sees pictures: it is right only as long as that stays.
            things=task.words_only
            and task.side is None
            and carried(task.begin_with, checkpoint, things_weights.FILE),
            outlines=carried(task.begin_with, checkpoint, outline_weights.FILE),
        )
        save(trainer.averaged(), processor, card, checkpoint)
        scores = measured(card, kept, checkpoint, seed=task.seed, threads=task.threads)
        scores |= {
            "steps": float(trainer.progress.steps),
            "minutes": trainer.look_at_clock() / 60.0,
            "pictures": float(len(used)),
        }
        write_scores(scores, task.out)
        return scores

    def _begin_with(self) -> tuple[Any, Any, Size, ModelCard]:
        """Return model, processor, size and card of --from; without it no model.

        Raises:
            ConfigError: the checkpoint is none, or is needed.
        """
        source = self._task.begin_with
        if source is None:
            if self._task.words_only:
                raise ConfigError(
                    "--words-only leaves what sees pictures as it is, and without --from nothing "
                    "sees any: name a checkpoint that does"
                )
            size = self._task.size
            size = resized(size, self._task.side or size.image)
            return None, None, size, ModelCard(name=self._task.name)
        card = read_card(check_directory(source), source.name)
        model, processor, size = read(source)
        model, processor, size = with_side(model, processor, size, self._task.side or size.image)
        return model, processor, size, card

    def _plan(self) -> Plan:
        task = self._task
        usual = task.plan.rate * (FINE_TUNING if task.begin_with else 1.0)
        bf16 = has_bf16() if task.precision == "auto" else task.precision == "bfloat16"
        return replace(
            task.plan,
            minutes=task.minutes,
            steps=task.steps,
            seed=task.seed,
            rate=task.rate or usual,
            words_only=task.words_only,
            bf16=bf16,
        )


def _some(pictures: Pictures) -> torch.Tensor:
    """Return a few pictures from all over the set, normalised."""
    every = max(1, len(pictures) // START_PICTURES)
    pixels = torch.from_numpy(pictures.pixels[::every].copy()).permute(0, 3, 1, 2)
    return normalise(pixels.float() / 255.0)
