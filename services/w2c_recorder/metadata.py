"""What a recording says of the system that made it."""

import platform
import time
from importlib import metadata

import w2c

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
