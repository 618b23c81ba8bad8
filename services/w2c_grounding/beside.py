"""A small network in a file of its own, beside the weights of a checkpoint."""

import shutil
from collections.abc import Mapping
from pathlib import Path

import torch
from safetensors import safe_open
from safetensors.torch import save_file

from w2c.errors import ModelError

Values = dict[str, torch.Tensor]


def write_halves(network: torch.nn.Module, path: Path, said: Mapping[str, str]) -> None:
    """Write the values of a network in half precision, and what is said of it."""
    halves = {
        name: (value.half() if value.is_floating_point() else value).contiguous()
        for name, value in network.state_dict().items()
    }
    save_file(halves, path, metadata=dict(said))
    # safetensors makes its file readable by its owner only.
    path.chmod(0o644)


def read_halves(path: Path) -> tuple[Values, dict[str, str]]:
    """Return the values of a file, in full precision, and what it says of them.

    Raises:
        OSError: it is missing.
        SafetensorError: it is damaged.
    """
    with safe_open(path, framework="pt") as file:
        values = {
            name: file.get_tensor(name).float()
            for name in file.keys()  # noqa: SIM118
        }
        return values, file.metadata() or {}


def damaged(path: Path, error: Exception, command: str) -> ModelError:
    """Return the error of a file that cannot be used; `command` makes it anew."""
    return ModelError(
        f"{path}: {error}; copy the whole checkpoint directory again, or make the file with: "
        f"{command}"
    )


def carried(source: Path | None, directory: Path, file: str) -> bool:
    """Copy such a file from one checkpoint directory to another; return whether there was one."""
    if source is None or not (source / file).is_file():
        return False
    directory.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(source / file, directory / file)
    return True
