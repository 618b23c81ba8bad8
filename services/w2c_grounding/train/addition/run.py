"""A training that adds a network to a checkpoint, from pictures to a checkpoint that has it."""

import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Protocol

import torch
from msgspec import structs

from w2c.clock import Clock
from w2c.errors import W2CError
from w2c_grounding.card import ModelCard, read_card
from w2c_grounding.registry import check_directory
from w2c_grounding.train.addition.trainer import AdditionTrainer
from w2c_grounding.train.data import truth_files
from w2c_grounding.train.measure import apart, write_scores
from w2c_grounding.train.pictures import digest
from w2c_grounding.train.plan import Plan, has_bf16
from w2c_grounding.train.trainer import read_state, save_state

Report = Callable[[str], None]


@dataclass(frozen=True)
class Task:
    """What was asked for; the flags of the command."""

    data: Path
    checkpoint: Path
    out: Path
    minutes: float = 30.0
    steps: int = 0
    seed: int = 0
    threads: int = 2
    rate: float = 2e-3
    name: str = ""
    resume: bool = False
    plan: Plan = field(default_factory=Plan)
    """Of it only what has no flag counts"""


@dataclass(frozen=True)
class Material:
    """What a training is made of."""

    task: Task
    kept: list[Path]
    """Truth files of pictures that are not trained on"""
    used: list[Path]
    card: ModelCard
    """Of the checkpoint, with the new name"""
    plan: Plan
    clock: Clock
    started_ns: int
    """When the command began"""
    report: Report


class Addition(Protocol):
    """What is added."""

    @property
    def trainer(self) -> AdditionTrainer:
        """Return what trains it."""

    def finish(self, checkpoint: Path) -> dict[str, float]:
        """Write the network into a copy of the checkpoint, and return its scores."""


def add(
    prepare: Callable[[Material], Addition],
    task: Task,
    clock: Clock,
    report: Report,
    stopped: Callable[[], bool] = lambda: False,
) -> dict[str, float] | None:
    """Train, and return the scores on the pictures kept back; None where it was stopped.

    Raises:
        ConfigError: a file is missing or damaged, or does not fit what is to be continued.
        W2CError: the disk is full.
    """
    started_ns = clock.now_ns()
    torch.set_num_threads(task.threads)
    torch.manual_seed(task.seed)
    files = truth_files(task.data)
    material = _material(task, files, clock, started_ns, report)
    addition = prepare(material)
    trainer = addition.trainer
    state = task.out / "state.pt"
    identity = {
        "data": digest(files),
        "seed": str(task.seed),
        "checkpoint": str(task.checkpoint.resolve()),
    }
    if task.resume:
        trainer.restore(read_state(state, identity))
    try:
        task.out.mkdir(parents=True, exist_ok=True)
        done = trainer.run(
            lambda: save_state({**trainer.state(), "identity": identity}, state), report, stopped
        )
        if not done:
            return None
        checkpoint = task.out / "checkpoint"
        shutil.copytree(task.checkpoint, checkpoint, dirs_exist_ok=True)
        scores = addition.finish(checkpoint)
    except OSError as error:
        raise W2CError(f"{task.out} cannot be written: {error}; free some space") from error
    scores |= {
        "steps": float(trainer.progress.steps),
        "minutes": trainer.look_at_clock() / 60.0,
    }
    write_scores(scores, task.out)
    return scores


def _material(
    task: Task, files: Sequence[Path], clock: Clock, started_ns: int, report: Report
) -> Material:
    kept, used = apart(list(files))
    card = read_card(check_directory(task.checkpoint), task.checkpoint.name)
    plan = replace(
        task.plan,
        minutes=task.minutes,
        steps=task.steps,
        seed=task.seed,
        rate=task.rate,
        bf16=has_bf16(),
    )
    report(f"{len(used)} pictures to train on, {len(kept)} kept back")
    return Material(
        task=task,
        kept=kept,
        used=used,
        card=structs.replace(card, name=task.name or card.name),
        plan=plan,
        clock=clock,
        started_ns=started_ns,
        report=report,
    )
