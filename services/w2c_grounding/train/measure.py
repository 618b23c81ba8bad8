"""Calibrates a checkpoint on pictures that its training kept back, and scores it there."""

from pathlib import Path

import msgspec

from w2c.errors import ConfigError
from w2c_grounding.card import ModelCard, write_card
from w2c_grounding.model_config import ModelConfig
from w2c_grounding.registry import load
from w2c_grounding.train.score import calibrate, run_trials, summarise

KEPT = 20
"""One picture in so many is kept back"""
CALIBRATION_PICTURES = 300
"""Of those kept back, at most: from 60 for the threshold it came out as .172, from 180 as .100"""


def apart(files: list[Path]) -> tuple[list[Path], list[Path]]:
    """Return the pictures that are kept back, and those to train on, of at least one.

    Raises:
        ConfigError: none is left to train on.
    """
    used = [file for number, file in enumerate(files) if number % KEPT]
    if not used:
        raise ConfigError(
            f"{files[0].parent} holds {len(files)} pictures; training needs at least 2"
        )
    return files[::KEPT], used


def measured(
    card: ModelCard, kept: list[Path], checkpoint: Path, *, seed: int, threads: int
) -> dict[str, float]:
    """Write the card with its threshold into a checkpoint directory, and return its scores.

    Half of the pictures kept back give the threshold, the others the scores.

    Raises:
        ConfigError: a picture is damaged.
        ModelError: the checkpoint is damaged.
    """
    write_card(card, checkpoint)
    family, _ = load(ModelConfig(model=str(checkpoint), threads=threads))
    some = kept[:: max(1, len(kept) // CALIBRATION_PICTURES)]
    threshold = calibrate(run_trials(family, some[::2], seed, edge=card.edge))
    write_card(msgspec.structs.replace(card, threshold=threshold), checkpoint)
    scored = run_trials(family, some[1::2] or some, seed, edge=card.edge)
    found = summarise(scored, threshold)
    return {"threshold": threshold, **{name: value for name, (value, _) in found.items()}}


def write_scores(scores: dict[str, float], directory: Path) -> None:
    """Write scores.json."""
    encoded = msgspec.json.format(msgspec.json.encode(scores), indent=1)
    (directory / "scores.json").write_bytes(encoded + b"\n")
