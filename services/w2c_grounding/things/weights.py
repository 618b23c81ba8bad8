"""The file of the network of things beside the weights of a checkpoint."""

from pathlib import Path

from safetensors import SafetensorError

from w2c_grounding.beside import damaged, read_halves, write_halves
from w2c_grounding.things.network import ThingsNetwork

FILE = "things.safetensors"
_WIDTH = "width"


def write(network: ThingsNetwork, directory: Path) -> None:
    """Write a network into a checkpoint directory, in half precision."""
    write_halves(network, directory / FILE, {_WIDTH: str(network.width)})


def read(directory: Path) -> ThingsNetwork:
    """Return the network of a checkpoint directory, in full precision, ready to answer.

    Raises:
        ModelError: the file is missing, damaged, or not of `write`.
    """
    path = directory / FILE
    try:
        values, said = read_halves(path)
        network = ThingsNetwork(int(said.get(_WIDTH, "")))
        network.load_state_dict(values)
    except (OSError, SafetensorError, ValueError, RuntimeError) as error:
        raise damaged(path, error, "w2c train things") from error
    return network.eval()
