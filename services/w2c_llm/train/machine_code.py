"""A network as machine code: operations between matrix products become one pass over memory."""

import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import torch
from torch._dynamo.exc import TorchDynamoException

from w2c.errors import ConfigError


def as_machine_code(network: torch.nn.Module) -> Callable[..., Any]:
    """Return what calls a network, and is compiled when it is first called and learned from.

    Its weights are those of the network. Raises ConfigError where there is no compiler.
    """
    compiler = os.environ.get("CXX", "g++")
    if shutil.which(compiler) is None:
        raise ConfigError(
            f"--compile needs a C++ compiler and found no {compiler}: install one (Debian: "
            "apt install g++ python3-dev), or leave --compile out"
        )
    # Batches have lengths of their own: one program for all of them.
    program: Callable[..., Any] = torch.compile(network, dynamic=True)
    return program


@contextmanager
def compiling() -> Iterator[None]:
    """Tell what is wrong where a first step cannot be compiled. Raises ConfigError."""
    try:
        yield
    except TorchDynamoException as error:
        lines = [line.strip() for line in str(error).splitlines() if line.strip()]
        reason = next((line for line in lines if "error:" in line), "".join(lines[:1]))
        raise ConfigError(
            f"--compile: the network cannot be compiled ({reason or type(error).__name__}); "
            "Debian's packages g++ and python3-dev are needed; or leave --compile out"
        ) from error
