"""The launcher with real processes: router and recorder, the two that need nothing else."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import psutil
import pytest

from support.ports import free_endpoint
from support.waiting import wait_until
from w2c.bus.zenoh_bus import connect
from w2c.config import ServiceConfig
from w2c.errors import ProcessError
from w2c_launcher.launcher import Launcher
from w2c_launcher.profiles import ProcessSpec


class Setup:
    """A launcher of router and recorder, attached to its bus."""

    def __init__(
        self, directory: Path, stack: ExitStack, recorder_flags: tuple[str, ...] = ()
    ) -> None:
        self.endpoint = free_endpoint()
        self.progress: list[tuple[str, str]] = []
        common = ("--robot", "test", "--router", self.endpoint, "--run-directory", str(directory))
        specs = [
            ProcessSpec("router", ("--listen", self.endpoint), 0, 9, joins_bus=False),
            ProcessSpec("recorder", (*common, *recorder_flags), 1, 1),
        ]
        self.launcher = Launcher(
            specs, directory, lambda name, text: self.progress.append((name, text))
        )
        stack.callback(self.launcher.stop)
        self.launcher.start_stage(0)
        config = ServiceConfig(robot="test", router=self.endpoint)
        self.launcher.attach(stack.enter_context(connect(config, "launcher", [self.endpoint])))

    def start(self) -> None:
        self.launcher.start_stage(1)
        self.launcher.wait_ready(1, lambda: False)

    def pid(self, name: str) -> int:
        pid = next(p.pid for p in self.launcher.table().processes if p.name == name)
        assert pid is not None
        return pid


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    """Everything a test starts ends with it."""
    with ExitStack() as exit_stack:
        yield exit_stack


def test_a_killed_process_is_started_again_and_becomes_ready(
    tmp_path: Path, stack: ExitStack
) -> None:
    setup = Setup(tmp_path, stack)
    setup.start()
    first = setup.pid("recorder")
    os.kill(first, signal.SIGKILL)

    def ready_again() -> bool:
        setup.launcher.watch()
        return setup.launcher.all_ready and setup.pid("recorder") != first

    wait_until(ready_again, 60)
    row = next(p for p in setup.launcher.table().processes if p.name == "recorder")
    assert row.restarts == 1


def test_stopping_ends_every_process_in_order(tmp_path: Path, stack: ExitStack) -> None:
    setup = Setup(tmp_path, stack)
    setup.start()
    pids = [setup.pid("recorder"), setup.pid("router")]
    setup.launcher.stop()
    assert not [pid for pid in pids if psutil.pid_exists(pid)]
    assert [name for name, text in setup.progress if text == "stopped"] == ["recorder", "router"]


def test_wrong_usage_is_not_tried_again_and_its_words_are_shown(
    tmp_path: Path, stack: ExitStack
) -> None:
    setup = Setup(tmp_path, stack, recorder_flags=("--no-such-flag",))
    with pytest.raises(ProcessError, match=r"recorder does not start: exit status 2.*"):
        setup.start()


def test_children_end_with_a_launcher_that_is_killed(tmp_path: Path) -> None:
    """No process of the simulation outlives its launcher."""
    code = (
        "import sys, time; from pathlib import Path; from w2c_launcher.child import Child;"
        f"child = Child('router', ('--listen', {free_endpoint()!r}), Path({str(tmp_path)!r}));"
        "print(child.pid, flush=True); time.sleep(600)"
    )
    parent = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    with parent:
        assert parent.stdout is not None
        child = psutil.Process(int(parent.stdout.readline()))
        wait_until(lambda: "router" in child.cmdline(), 30)
        parent.kill()

    def gone() -> bool:
        return not child.is_running() or child.status() == psutil.STATUS_ZOMBIE

    wait_until(gone, 30)
