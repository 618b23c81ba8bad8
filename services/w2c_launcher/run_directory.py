"""`runs/<stamp>/`: logs, recording and results of one run; `runs/current` points to the newest."""

import shutil
import time
from pathlib import Path

from w2c.errors import ConfigError
from w2c.system import CURRENT, RUNS

LEAST_FREE_BYTES = 500_000_000


def make_run_directory(chosen: str = "") -> Path:
    """Create the directory of a run and return its absolute path. Raises ConfigError."""
    path = Path(chosen) if chosen else RUNS / time.strftime("%Y-%m-%d_%H-%M-%S")
    try:
        path.mkdir(parents=True, exist_ok=True)
        free = shutil.disk_usage(path).free
    except OSError as error:
        raise ConfigError(
            f"cannot create {path}: {error}; choose another --run-directory"
        ) from error
    if free < LEAST_FREE_BYTES:
        raise ConfigError(
            f"{free / 1e6:.0f} MB free at {path}, a session needs {LEAST_FREE_BYTES / 1e6:.0f} MB; "
            "make room, or choose another --run-directory"
        )
    return path.resolve()


def point_current_to(run_directory: Path) -> None:
    """Make `runs/current` a link to the run."""
    RUNS.mkdir(exist_ok=True)
    temporary = RUNS / ".current"
    temporary.unlink(missing_ok=True)
    temporary.symlink_to(run_directory)
    temporary.replace(CURRENT)
