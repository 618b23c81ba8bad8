"""Start a private system for an experiment, and end it whatever happens."""

import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from w2c.errors import ProcessError
from w2c.system import SystemFile, read_system_file

START_PATIENCE_S = 300.0
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
            yield _wait_until_ready(run_directory, launcher)
        finally:
            launcher.send_signal(signal.SIGTERM)
            try:
                launcher.wait(STOP_PATIENCE_S)
            except subprocess.TimeoutExpired:
                launcher.kill()
                launcher.wait()


def _wait_until_ready(run_directory: Path, launcher: "subprocess.Popen[bytes]") -> SystemFile:
    deadline = time.monotonic() + START_PATIENCE_S
    while time.monotonic() < deadline:
        status = launcher.poll()
        if status is not None:
            raise ProcessError(
                f"the system did not start (exit status {status}); see the logs in {run_directory}"
            )
        system = read_system_file(run_directory)
        if system is not None and system.pid == launcher.pid and system.state == "ready":
            return system
        time.sleep(0.1)
    raise ProcessError(f"not ready within {START_PATIENCE_S:.0f} s; see {run_directory}")
