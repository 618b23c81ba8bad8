"""`w2c ground use NAME`: the running grounding processes answer with another model from now on."""

import time
from pathlib import Path
from typing import Annotated

import msgspec
import tyro

from w2c import topics
from w2c.bus import Bus
from w2c.config import parse
from w2c.errors import ConfigError, UnavailableError
from w2c.messages import UseModelReply, UseModelRequest
from w2c.system import Connection, service_config

_PATIENCE_S = 3.0
"""Until a running replica is seen on the bus"""


class UseConfig(Connection, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Let grounding answer with another model, without losing a request.

    The new model is loaded beside the old one, which answers until the new one can. What cannot be
    loaded changes nothing. With several replicas one changes after the other.
    """

    model: tyro.conf.Positional[Annotated[str, msgspec.Meta(min_length=1, max_length=1000)]]
    """A name of 'w2c ground models', 'embedded', or a directory or hub id on the machine of the
    grounding process."""
    family: str = ""
    """Kind of model; empty = what the checkpoint says of itself. Needed for pointer."""
    replica: str = ""
    """Only the one that was started with this --instance; empty = every one."""


def use(arguments: list[str]) -> int:
    """Run the verb. Exit status: 0 done, 1 failed, 2 usage."""
    from w2c.bus.zenoh_bus import connect

    config = parse(UseConfig, arguments, program="w2c ground use")
    service = service_config(config)
    with connect(service, "operator", [service.router]) as bus:
        replicas = [config.replica] if config.replica else replicas_of(bus, _PATIENCE_S)
        change_each(bus, replicas, config.model, config.family)
    return 0


def change_each(bus: Bus, replicas: list[str], model: str, family: str) -> None:
    """Let each replica change its model, one after the other; print a line each.

    Raises:
        CallError: one could not; those after it were not asked.
        ConfigError: the name is none.
    """
    request = _request(model, family)
    for replica in replicas:
        reply = bus.call(topics.USE_MODEL, request, instance=replica).message
        print(describe(replica, reply), flush=True)  # noqa: T201 - of a command


def replicas_of(bus: Bus, patience_s: float) -> list[str]:
    """Return the instances of grounding that run, waiting a little for the first to be seen.

    Raises:
        UnavailableError: none is seen.
    """
    end = time.monotonic() + patience_s
    while True:
        found = sorted(instance for service, instance in bus.alive() if service == "grounding")
        if found:
            return found
        if time.monotonic() > end:
            raise UnavailableError(
                "no grounding process is running; start the system with: w2c up, or it alone with: "
                "w2c grounding"
            )
        time.sleep(0.05)


def describe(replica: str, reply: UseModelReply) -> str:
    """Return what changed in one line for people."""
    instead = f" instead of {reply.previous}" if reply.previous else ""
    return (
        f"grounding {replica}: {reply.model} answers now{instead}; threshold "
        f"{reply.threshold:.2f}, loaded in {reply.seconds:.1f} s, {reply.memory_mb:.0f} MB"
    )


def _request(model: str, family: str) -> UseModelRequest:
    """Return the request, bounded as on the bus. Raises ConfigError."""
    # A path of this machine is told whole: the process may have been started elsewhere.
    path = Path(model).expanduser()
    name = str(path.resolve()) if "/" in model and path.is_dir() else model
    try:
        return msgspec.convert({"model": name, "family": family}, UseModelRequest)
    except msgspec.ValidationError as error:
        raise ConfigError(f"this cannot be asked: {error}") from error
