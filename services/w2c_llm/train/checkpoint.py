"""What a killed run goes on from, and what another run may begin with."""

from dataclasses import dataclass
from pathlib import Path
from pickle import UnpicklingError
from typing import Any

import torch
from tokenizers import Tokenizer

from w2c.errors import ConfigError

VERSION = 2


@dataclass(frozen=True)
class Checkpoint:
    """Contents of a checkpoint's file."""

    identity: dict[str, str]
    """What must be the same in a run that goes on: seed, data, shape"""
    size: dict[str, int]
    """Fields of `NetworkSize`"""
    tokenizer: str
    """JSON of the tokenizer"""
    trainer: dict[str, Any]
    """`Trainer.state`"""


def save(path: Path, checkpoint: Checkpoint) -> None:
    """Write a checkpoint, whole or not at all. Raises OSError."""
    partial = path.with_suffix(".partial")
    try:
        # To an open file: given a path, torch raises a RuntimeError for a full disk.
        with partial.open("wb") as file:
            torch.save({"version": VERSION, **vars(checkpoint)}, file)
        partial.replace(path)
    except BaseException:
        partial.unlink(missing_ok=True)
        raise


def load(path: Path) -> Checkpoint:
    """Return a checkpoint.

    Raises:
        ConfigError: there is none, it is damaged, or of another version of this program.
    """
    if not path.is_file():
        raise ConfigError(f"no checkpoint at {path}")
    try:
        content = torch.load(path, map_location="cpu", weights_only=True)
    except (OSError, RuntimeError, EOFError, ValueError, UnpicklingError) as error:
        raise ConfigError(f"{path} is no checkpoint of this program, or damaged") from error
    if not isinstance(content, dict) or content.pop("version", None) != VERSION:
        raise ConfigError(f"{path} is a checkpoint of another version of this program")
    return Checkpoint(**content)


def expect_same(path: Path, checkpoint: Checkpoint, identity: dict[str, str]) -> None:
    """Refuse to go on with anything but what the run began with. Raises ConfigError."""
    changed = [
        f"{name} was {checkpoint.identity.get(name, 'not given')}, now "
        f"{identity.get(name, 'not given')}"
        for name in {**checkpoint.identity, **identity}
        if checkpoint.identity.get(name) != identity.get(name)
    ]
    if changed:
        raise ConfigError(
            f"{path} is of another run: {'; '.join(changed)}. Resume with what it began with, "
            "or begin anew with --from"
        )


def tokenizer_of(checkpoint: Checkpoint) -> Tokenizer:
    """Return the tokenizer of a checkpoint."""
    return Tokenizer.from_str(checkpoint.tokenizer)
