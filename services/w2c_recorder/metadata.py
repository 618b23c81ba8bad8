"""What a recording says of the system that made it."""

import platform
import time
from importlib import metadata

import w2c
from w2c.messages import Health

PACKAGES = ("eclipse-zenoh", "mcap", "msgpack", "msgspec", "numpy")


def versions() -> dict[str, str]:
    """Return program -> version of what decides how messages are made and written."""
    found = {"w2c": w2c.__version__, "python": platform.python_version()}
    for package in PACKAGES:
        try:
            found[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            found[package] = "not installed"
    return found


def session_metadata(robot: str, run_directory: str, boot_id: str) -> dict[str, str]:
    """Return the metadata record at the beginning of a recording."""
    return {
        **versions(),
        "robot": robot,
        "host": platform.node(),
        "platform": platform.platform(),
        "run_directory": run_directory,
        "recorder_boot_id": boot_id,
        "start_clock_ns": str(time.time_ns()),
        "start_monotonic_ns": str(time.monotonic_ns()),
    }


PROCESS_PREFIX = "process "
"""Of the metadata records that tell what a process is: `process llm/0`"""
CLOCKS_METADATA = "clocks"
"""Sender -> least time that one of its messages was on its way [ns], by the clocks of both ends: a
clock that is ahead of the recorder's makes it negative"""


class Processes:
    """What the processes say of themselves in their health reports; told once a file."""

    def __init__(self) -> None:
        self._known: dict[str, dict[str, str]] = {}
        self._told: dict[str, dict[str, str]] = {}

    def note(self, health: Health) -> None:
        """Take a report."""
        if health.facts:
            self._known[f"{PROCESS_PREFIX}{health.service}/{health.instance}"] = health.facts

    def begin_file(self) -> None:
        """Tell all of it again: each file can be read alone."""
        self._told = {}

    def news(self) -> dict[str, dict[str, str]]:
        """Return name -> facts of what was not told yet, or has changed since."""
        found = {
            name: facts for name, facts in self._known.items() if self._told.get(name) != facts
        }
        self._told |= found
        return found
