"""The file of the second look beside the weights of a checkpoint."""

import json
from pathlib import Path

import msgspec
from safetensors import SafetensorError

from w2c_grounding.beside import damaged, read_halves, write_halves
from w2c_grounding.second_look.network import SecondLookNetwork

FILE = "second_look.safetensors"
_VOCABULARY = "vocabulary"


def write(network: SecondLookNetwork, directory: Path) -> None:
    """Write a network into a checkpoint directory, in half precision."""
    write_halves(network, directory / FILE, {_VOCABULARY: json.dumps(network.vocabulary)})


def read(directory: Path) -> SecondLookNetwork:
    """Return the network of a checkpoint directory, in full precision, ready to answer.

    Raises:
        ModelError: the file is missing, damaged, or not of `write`.
    """
    path = directory / FILE
    try:
        values, said = read_halves(path)
        network = SecondLookNetwork(msgspec.json.decode(said.get(_VOCABULARY, ""), type=list[str]))
        network.load_state_dict(values)
    except (OSError, SafetensorError, msgspec.DecodeError, RuntimeError) as error:
        raise damaged(path, error, "w2c train second-look") from error
    return network.eval()
