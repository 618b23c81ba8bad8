"""A training of the second look, from pictures to a checkpoint that has one."""

import shutil
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import msgspec
import torch

from w2c.clock import Clock
from w2c.errors import W2CError
from w2c_grounding.card import read_card
from w2c_grounding.registry import check_directory
from w2c_grounding.second_look import weights
from w2c_grounding.second_look.network import SecondLookNetwork, with_words
from w2c_grounding.train.data import truth_files
from w2c_grounding.train.measure import apart, measured, write_scores
from w2c_grounding.train.pictures import digest
from w2c_grounding.train.plan import Plan, has_bf16
from w2c_grounding.train.second_look.squares import cut_out
from w2c_grounding.train.second_look.trainer import SecondLookTrainer
from w2c_grounding.train.trainer import read_state, save_state
from w2c_grounding.train.vocabulary import vocabulary_of


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


def run(
    task: Task,
    clock: Clock,
    report: Callable[[str], None],
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
    kept, used = apart(files)
    card = read_card(check_directory(task.checkpoint), task.checkpoint.name)
    report(f"{len(used)} pictures to train on, {len(kept)} kept back; cutting out their things")
    squares = cut_out(used, task.seed, task.threads)
    plan = replace(
        task.plan,
        minutes=task.minutes,
        steps=task.steps,
        seed=task.seed,
        rate=task.rate,
        bf16=has_bf16(),
    )
    vocabulary = vocabulary_of(squares.truths)
    if card.second_look:
        network = with_words(weights.read(task.checkpoint), vocabulary)
    else:
        network = SecondLookNetwork(vocabulary)
    trainer = SecondLookTrainer(network, squares, plan, clock, started_ns)
    state = task.out / "state.pt"
    identity = {
        "data": digest(files),
        "seed": str(task.seed),
        "checkpoint": str(task.checkpoint.resolve()),
    }
    if task.resume:
        trainer.restore(read_state(state, identity))
    checkpoint = task.out / "checkpoint"
    try:
        task.out.mkdir(parents=True, exist_ok=True)
        done = trainer.run(
            lambda: save_state({**trainer.state(), "identity": identity}, state), report, stopped
        )
        if not done:
            return None
        shutil.copytree(task.checkpoint, checkpoint, dirs_exist_ok=True)
        weights.write(network.eval(), checkpoint)
        looking = msgspec.structs.replace(card, second_look=True, name=task.name or card.name)
        scores = measured(looking, kept, checkpoint, seed=task.seed, threads=task.threads)
    except OSError as error:
        raise W2CError(f"{task.out} cannot be written: {error}; free some space") from error
    scores |= {
        "steps": float(trainer.progress.steps),
        "minutes": trainer.look_at_clock() / 60.0,
        "squares": float(len(squares.cuts)),
    }
    write_scores(scores, task.out)
    return scores
