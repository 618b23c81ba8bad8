"""A whole system for one experiment: started on private ports, ended whatever happens."""

import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from w2c.system import SystemFile, wait_until_ready

STOP_PATIENCE_S = 60.0


@contextmanager
def running_system(run_directory: Path, flags: list[str], *, quiet: bool) -> Iterator[SystemFile]:
    """Run `w2c up --private` with these flags while the block runs.

    The launcher's progress goes to the terminal, or to `launcher.log` where `quiet`.

    Raises:
        ProcessError: the system did not become ready.
    """
    run_directory.mkdir(parents=True, exist_ok=True)
    command = [sys.executable, "-m", "w2c.cli", "up", "--private", *flags]
    command += ["--run-directory", str(run_directory)]
    with (run_directory / "launcher.log").open("ab") as log:
        launcher = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=log if quiet else None,
            stderr=log if quiet else None,
        )
        try:
            yield wait_until_ready(run_directory, launcher.pid, launcher.poll)
        finally:
            launcher.send_signal(signal.SIGTERM)
            try:
                launcher.wait(STOP_PATIENCE_S)
            except subprocess.TimeoutExpired:
                launcher.kill()
                launcher.wait()
