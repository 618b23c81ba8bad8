"""Where the running system is: a small file in its run directory, which every verb reads."""

import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Literal

import msgspec

from w2c.config import RobotId, ServiceConfig
from w2c.errors import ConfigError, ConnectionFailedError, ProcessError

RUNS = Path("runs")
CURRENT = RUNS / "current"
FILE_NAME = "system.json"
START_PATIENCE_S = 300.0


class SystemFile(msgspec.Struct, frozen=True, kw_only=True):
    """What `w2c up` writes about the system that it runs."""

    state: Literal["starting", "ready", "degraded", "stopping", "stopped"]
    pid: int
    """Of the launcher"""
    robot: str
    router: str
    robot_endpoint: str
    console_url: str
    run_directory: str
    profile: str
    detail: str = ""


class Connection(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How a verb reaches a running system; empty = read from `runs/current/system.json`."""

    robot: str = ""
    """Id of the robot."""
    router: str = ""
    """Endpoint of the router."""
    robot_endpoint: str = ""
    """Endpoint of the robot driver."""
    timeout: Annotated[float, msgspec.Meta(gt=0)] = 3.0
    """How long to try to connect [s]."""


def write_system_file(system: SystemFile) -> None:
    """Write the file so that a reader never sees half of it."""
    path = Path(system.run_directory) / FILE_NAME
    temporary = path.with_suffix(".tmp")
    temporary.write_bytes(msgspec.json.format(msgspec.json.encode(system)))
    temporary.replace(path)


def read_system_file(run_directory: Path) -> SystemFile | None:
    """Return what the file says; None where there is none. Raises ConfigError for a broken one."""
    path = run_directory / FILE_NAME
    try:
        return msgspec.json.decode(path.read_bytes(), type=SystemFile)
    except FileNotFoundError:
        return None
    except (OSError, msgspec.DecodeError) as error:
        raise ConfigError(f"{path} cannot be read: {error}; remove it") from error


def is_running(system: SystemFile) -> bool:
    """Tell whether the launcher that wrote the file still lives."""
    if system.state == "stopped":
        return False
    try:
        os.kill(system.pid, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return True


def wait_until_ready(
    run_directory: Path,
    pid: int,
    exit_status: Callable[[], int | None],
    patience_s: float = START_PATIENCE_S,
) -> SystemFile:
    """Return the file of a system that a child process starts, once it is ready.

    Args:
        run_directory: Of the system.
        pid: Of the launcher.
        exit_status: Of the launcher, None while it runs.
        patience_s: How long to wait [s].

    Raises:
        ProcessError: the launcher ended, or took longer.
    """
    deadline = time.monotonic() + patience_s
    while time.monotonic() < deadline:
        status = exit_status()
        system = read_system_file(run_directory)
        if system is not None and system.pid != pid:
            system = None  # of an earlier run
        if status is not None or (system is not None and system.state in ("stopping", "stopped")):
            detail = system.detail if system is not None else ""
            raise ProcessError(
                f"the system did not start: {detail or f'exit status {status}'}; "
                f"see the logs in {run_directory}"
            )
        if system is not None and system.state == "ready":
            return system
        time.sleep(0.1)
    raise ProcessError(f"not ready within {patience_s:.0f} s; see the logs in {run_directory}")


def service_config(connection: Connection) -> ServiceConfig:
    """Return the connection completed from the running system's file.

    Raises:
        ConnectionFailedError: nothing runs here, and no endpoint was given.
    """
    system = read_system_file(CURRENT)
    if (system is None or not is_running(system)) and not (connection.router and connection.robot):
        raise ConnectionFailedError(
            f"no system runs from {Path.cwd()} (no live {CURRENT / FILE_NAME}). "
            "Start one with: w2c up. Or name one with: --robot ID --router ENDPOINT"
        )
    defaults = {} if system is None else msgspec.to_builtins(system)
    values = {
        name: getattr(connection, name) or defaults.get(name, "")
        for name in ("robot", "router", "robot_endpoint")
    }
    values = {name: value for name, value in values.items() if value}
    return msgspec.convert({**values, "connect_timeout": connection.timeout}, ServiceConfig)


__all__ = [
    "CURRENT",
    "RUNS",
    "Connection",
    "RobotId",
    "SystemFile",
    "is_running",
    "read_system_file",
    "service_config",
    "wait_until_ready",
    "write_system_file",
]
