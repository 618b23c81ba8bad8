"""The file of the second look beside the weights of a checkpoint."""

import json
import shutil
from pathlib import Path

import msgspec
import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save_file

from w2c.errors import ModelError
from w2c_grounding.second_look.network import SecondLookNetwork

FILE = "second_look.safetensors"
_VOCABULARY = "vocabulary"


def write(network: SecondLookNetwork, directory: Path) -> None:
    """Write a network into a checkpoint directory, in half precision."""
    halves = {
        name: (value.half() if value.is_floating_point() else value).contiguous()
        for name, value in network.state_dict().items()
    }
    path = directory / FILE
    save_file(halves, path, metadata={_VOCABULARY: json.dumps(network.vocabulary)})
    # safetensors makes its file readable by its owner only.
    path.chmod(0o644)


def carried(source: Path | None, directory: Path) -> bool:
    """Copy the file from one checkpoint directory to another; return whether there was one."""
    if source is None or not (source / FILE).is_file():
        return False
    directory.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(source / FILE, directory / FILE)
    return True


def read(directory: Path) -> SecondLookNetwork:
    """Return the network of a checkpoint directory, in full precision, ready to answer.

    Raises:
        ModelError: the file is missing, damaged, or not of `write`.
    """
    path = directory / FILE
    try:
        with safe_open(path, framework="pt") as file:
            vocabulary = msgspec.json.decode(
                (file.metadata() or {}).get(_VOCABULARY, ""), type=list[str]
            )
            values: dict[str, torch.Tensor] = {
                name: file.get_tensor(name).float()
                for name in file.keys()  # noqa: SIM118
            }
        network = SecondLookNetwork(vocabulary)
        network.load_state_dict(values)
    except (OSError, SafetensorError, msgspec.DecodeError, RuntimeError) as error:
        raise ModelError(
            f"{path}: {error}; copy the whole checkpoint directory again, or make the file with: "
            "w2c train second-look"
        ) from error
    return network.eval()
