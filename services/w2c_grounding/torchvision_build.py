"""Some models need torchvision, in the build that fits torch; a wrong one breaks every model."""

import importlib

from w2c.errors import ConfigError


def need_torchvision(who: str) -> None:
    """Return where torchvision works.

    It is no dependency of this project: on PyPI it is built for one kind of GPU, and beside a torch
    for the CPU not even transformers' own classes can be imported any more.

    Raises:
        ConfigError: it is missing or does not fit; the message says how to get the right one.
    """
    torch = importlib.import_module("torch")
    try:
        importlib.import_module("torchvision")
    except ModuleNotFoundError:
        problem = "is not installed"
    # A build that does not fit says so by whichever of these is met first.
    except (ImportError, RuntimeError, OSError) as error:
        problem = f"does not fit torch {torch.__version__} ({str(error).splitlines()[0][:200]})"
    else:
        return
    raise ConfigError(
        f"{who} needs torchvision, which {problem}. Install both from the same index, as in: "
        "pip install torch==2.13.0 torchvision==0.28.0 --index-url "
        "https://download.pytorch.org/whl/cpu (or cu130 for a GPU); or use another model"
    )
