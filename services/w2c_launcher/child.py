"""One child process of the launcher: started, watched, ended."""

import os
import signal
import subprocess
import sys
from pathlib import Path

from w2c.errors import ProcessError

STOP_PATIENCE_S = 6.0
QUIET_THREADS = {"OMP_WAIT_POLICY": "PASSIVE", "OPENBLAS_NUM_THREADS": "1"}
"""Libraries whose threads spin while they wait would take the cores that the 500 Hz loop needs."""

# The child asks the kernel to be told when its parent dies, then becomes the service: so no process
# of the simulation outlives its launcher, even one that was killed. (On Linux.)
_BOOTSTRAP = """
import ctypes, os, signal, sys
from w2c_launcher.niceness import give_way
parent = int(sys.argv[1])
if sys.platform == "linux":
    ctypes.CDLL(None).prctl(1, signal.SIGTERM)
    if os.getppid() != parent:
        sys.exit(1)
give_way(int(sys.argv[2]))
os.execv(sys.executable, [sys.executable, "-m", "w2c.cli", *sys.argv[3:]])
"""


class Child:
    """A running `w2c VERB`. Its output goes to `<run_directory>/<name>.log`."""

    def __init__(
        self, name: str, flags: tuple[str, ...], run_directory: Path, niceness: int = 0
    ) -> None:
        """Start it. Raises ProcessError.

        Args:
            name: of the verb.
            flags: of the verb.
            run_directory: for its log.
            niceness: how far it gives way to others, 0 to 19.
        """
        self.name = name
        self.log_path = run_directory / f"{name}.log"
        try:
            with self.log_path.open("ab") as log:
                self._process = subprocess.Popen(
                    [
                        *(sys.executable, "-c", _BOOTSTRAP, str(os.getpid()), str(niceness)),
                        *(name, *flags),
                    ],
                    stdin=subprocess.DEVNULL,
                    stdout=log,
                    stderr=log,
                    env={**os.environ, **QUIET_THREADS},
                    # Ctrl-C in the terminal reaches the launcher alone, which stops in order.
                    start_new_session=True,
                )
        except OSError as error:
            raise ProcessError(f"{name} cannot be started: {error}") from error

    @property
    def pid(self) -> int:
        """Return the process id."""
        return self._process.pid

    @property
    def exit_status(self) -> int | None:
        """Return the exit status; None while it runs, negative = killed by that signal."""
        return self._process.poll()

    def terminate(self) -> None:
        """Ask it to end."""
        if self._process.poll() is None:
            self._process.send_signal(signal.SIGTERM)

    def wait_or_kill(self, patience_s: float = STOP_PATIENCE_S) -> bool:
        """Return True when it ended by itself; False when it had to be killed."""
        try:
            self._process.wait(patience_s)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
            return False
        return True

    def last_words(self, lines: int = 4) -> str:
        """Return the end of its log."""
        try:
            text = self.log_path.read_text(errors="replace").strip()
        except OSError:
            return ""
        return " | ".join(text.splitlines()[-lines:])
