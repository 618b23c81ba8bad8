"""The mean of what several trainings learned."""

from collections.abc import Sequence
from pathlib import Path

from w2c.errors import ConfigError
from w2c_llm.train.growth import deepened
from w2c_llm.train.origin import Origin, read_origin


def read_origins(paths: Sequence[Path], layers: int | None = None) -> Origin:
    """Return a network whose weights are the mean of those of files, with their tokenizer.

    Trainings that went on from the same weights differ by what each learned and by noise; the mean
    keeps more of the first than of the second (Wortsman et al., "Model soups", ICML 2022). So does
    the mean of a training and of what it began with, also where it is the deeper of the two.

    Args:
        paths: GGUF files or checkpoints of this trainer.
        layers: Of the network; those with fewer layers are deepened first. None: of the first file.

    Raises:
        ConfigError: as `read_origin` and `deepened`; or they differ in size or tokenizer.
    """
    first = _read(paths[0], layers)
    total = dict(first.network.state_dict())
    for path in paths[1:]:
        other = _read(path, layers)
        same_words = other.tokenizer.get_vocab() == first.tokenizer.get_vocab()
        if other.size != first.size or not same_words:
            raise ConfigError(
                f"{path} has another size or tokenizer than {paths[0]}: there is no mean of their "
                "weights; give --from models of one family, and --layers if they differ in depth"
            )
        total = {name: total[name] + value for name, value in other.network.state_dict().items()}
    first.network.load_state_dict({name: value / len(paths) for name, value in total.items()})
    return first


def _read(path: Path, layers: int | None) -> Origin:
    origin = read_origin(path)
    return origin if layers is None else deepened(origin, layers)
