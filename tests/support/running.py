"""A whole system, started as `w2c up --private`."""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from support.waiting import wait_until
from w2c.bus.zenoh_bus import ZenohBus, connect
from w2c.config import ServiceConfig
from w2c.system import SystemFile, read_system_file


class RunningSystem:
    """`w2c up --private` and what is known of it."""

    def __init__(self, file: SystemFile, launcher: "subprocess.Popen[bytes]") -> None:
        self.file = file
        self.launcher = launcher
        self.config = ServiceConfig(
            robot=file.robot, router=file.router, robot_endpoint=file.robot_endpoint
        )

    @property
    def directory(self) -> Path:
        """Where it writes."""
        return Path(self.file.run_directory)

    def connect(self, service: str = "evaluation") -> ZenohBus:
        """Return a bus of one's own."""
        return connect(self.config, service, [self.config.router])

    def verb(self, *words: str) -> "subprocess.CompletedProcess[str]":
        """Run a verb of the operator against it."""
        where = [
            *("--robot", self.file.robot, "--router", self.file.router),
            *("--robot-endpoint", self.file.robot_endpoint),
        ]
        return subprocess.run(
            [sys.executable, "-m", "w2c.cli", *words, *where],
            capture_output=True,
            text=True,
            check=False,
        )


@contextmanager
def run_system(directory: Path, *flags: str) -> Iterator[RunningSystem]:
    """Start a system, wait until it is ready, stop it in the end."""
    command = [sys.executable, "-m", "w2c.cli", "up", "--private"]
    with (directory / "launcher.log").open("wb") as log:
        launcher = subprocess.Popen(
            [*command, "--run-directory", str(directory), *flags], stdout=log, stderr=log
        )
        try:

            def ready() -> bool:
                words = (directory / "launcher.log").read_text()
                assert launcher.poll() is None, words
                file = read_system_file(directory)
                return file is not None and file.state == "ready"

            wait_until(ready, 240)
            file = read_system_file(directory)
            assert file is not None
            yield RunningSystem(file, launcher)
        finally:
            launcher.terminate()
            launcher.wait(60)
