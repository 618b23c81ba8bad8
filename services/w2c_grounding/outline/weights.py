"""The file of the outlines beside the weights of a checkpoint."""

from pathlib import Path

from safetensors import SafetensorError

from w2c_grounding.beside import damaged, read_halves, write_halves
from w2c_grounding.outline.network import OutlineNetwork

FILE = "outline.safetensors"


def write(network: OutlineNetwork, directory: Path) -> None:
    """Write a network into a checkpoint directory, in half precision."""
    write_halves(network, directory / FILE, {})


def read(directory: Path) -> OutlineNetwork:
    """Return the network of a checkpoint directory, in full precision, ready to draw.

    Raises:
        ModelError: the file is missing, damaged, or not of `write`.
    """
    path = directory / FILE
    network = OutlineNetwork()
    try:
        network.load_state_dict(read_halves(path)[0])
    except (OSError, SafetensorError, RuntimeError) as error:
        raise damaged(path, error, "w2c train outline") from error
    return network.eval()
