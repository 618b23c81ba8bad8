"""A network as machine code: operations between matrix products become one pass over memory."""

import os
import shutil
from collections.abc import Callable
from typing import Any

import torch
from torch._dynamo.exc import TorchDynamoException

from w2c.errors import ConfigError

_COMPILER = os.environ.get("CXX", "g++")


class MachineCode:
    """Calls a network that is compiled at its first call, in half a minute.

    Its weights are those of the network.
    """

    def __init__(self, network: torch.nn.Module) -> None:
        """Raises ConfigError where there is no compiler."""
        if shutil.which(_COMPILER) is None:
            raise ConfigError(
                f"--compile needs a C++ compiler and found no {_COMPILER}: install one (Debian: "
                "apt install g++ python3-dev), or leave --compile out"
            )
        # Batches have lengths of their own: one program for all of them.
        self._program: Callable[..., Any] = torch.compile(network, dynamic=True)

    def __call__(self, **arguments: torch.Tensor) -> Any:
        """Return what the network returns. Raises ConfigError where it cannot be compiled."""
        try:
            return self._program(**arguments)
        except TorchDynamoException as error:
            reason = str(error).strip().splitlines()[0]
            raise ConfigError(
                f"--compile: the network cannot be compiled ({reason}); leave --compile out"
            ) from error
