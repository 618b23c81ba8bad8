"""One frozen struct is a service's configuration, its flags and its help. TOML file < flags."""

import sys
import tomllib
from pathlib import Path
from typing import Annotated, Any, TypeVar

import msgspec

from w2c.errors import ConfigError

C = TypeVar("C", bound=msgspec.Struct)

RobotId = Annotated[str, msgspec.Meta(pattern=r"^[a-z0-9][a-z0-9_-]{0,31}$")]


class ServiceConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What every service needs to reach the others."""

    robot: RobotId
    """Id of the robot, part of every key. No default: two robots must never share keys."""
    router: str = "tcp/127.0.0.1:7447"
    """Endpoint of the router."""
    robot_endpoint: str = "tcp/127.0.0.1:7448"
    """Endpoint of the robot driver, the hub of the robot host."""
    instance: str = "0"
    """Which replica of the service this is."""
    connect_timeout: float = 20.0
    """How long to wait for the router or the robot at the start [s]."""
    log_level: str = "info"
    """debug, info, warning or error."""
    run_directory: str = ""
    """Where the process writes what it writes; empty = nothing but the terminal."""


def load(config_type: type[C], values: dict[str, Any]) -> C:
    """Validate decoded TOML into a configuration. Raises ConfigError with the path of the field."""
    try:
        return msgspec.convert(values, config_type, strict=True)
    except msgspec.ValidationError as error:
        known = ", ".join(config_type.__struct_fields__)
        raise ConfigError(f"configuration: {error}. Known fields: {known}") from error


def read_toml(path: Path) -> dict[str, Any]:
    """Return the tables of a TOML file. Raises ConfigError."""
    try:
        return tomllib.loads(path.read_text())
    except FileNotFoundError as error:
        raise ConfigError(f"no configuration file at {path}; check --config") from error
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigError(f"{path} cannot be read: {error}") from error
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{path} is not TOML: {error}") from error


def parse(config_type: type[C], arguments: list[str], *, program: str, table: str = "") -> C:
    """Return the configuration of `--config FILE` (its table `table`, or the whole file) and flags.

    Exits with status 2 for an unknown flag, as argparse does.

    Raises:
        ConfigError: the file or a value is wrong.
    """
    import tyro

    arguments = list(arguments)
    from_file: dict[str, Any] = {}
    if "--config" in arguments:
        at = arguments.index("--config")
        if at + 1 >= len(arguments):
            raise ConfigError("--config needs a file")
        from_file = read_toml(Path(arguments[at + 1]))
        del arguments[at : at + 2]
        if table:
            from_file = from_file.get(table, {})
    default = load(config_type, from_file) if from_file else None
    chosen = (
        tyro.cli(config_type, args=arguments, prog=program)
        if default is None
        else tyro.cli(config_type, args=arguments, prog=program, default=default)
    )
    # tyro does not check msgspec.Meta bounds: a second look does.
    return load(config_type, msgspec.to_builtins(chosen))


def fail(error: Exception, program: str) -> int:
    """Print an error for a person and return the exit status it stands for."""
    sys.stderr.write(f"{program}: {error}\n")
    return 2 if isinstance(error, ConfigError) else 1
