"""Finding the running system, and the command line's own errors."""

import os
import subprocess
import sys
from pathlib import Path

import msgspec
import pytest

from w2c import cli
from w2c.clock import StepClock
from w2c.errors import ConfigError, ConnectionFailedError, ProcessError
from w2c.system import (
    Connection,
    SystemFile,
    is_running,
    read_system_file,
    service_config,
    wait_until_ready,
    write_system_file,
)


def system_file(directory: Path, pid: int) -> SystemFile:
    return SystemFile(
        state="ready",
        pid=pid,
        robot="talos",
        router="tcp/127.0.0.1:1",
        robot_endpoint="tcp/127.0.0.1:2",
        console_url="http://127.0.0.1:3",
        run_directory=str(directory),
        profile="simulation",
    )


def test_the_file_of_the_running_system_is_read_back(tmp_path: Path) -> None:
    system = system_file(tmp_path, os.getpid())
    write_system_file(system)
    assert read_system_file(tmp_path) == system
    assert is_running(system)


def test_no_file_means_no_system(tmp_path: Path) -> None:
    assert read_system_file(tmp_path) is None


def test_a_broken_file_is_named(tmp_path: Path) -> None:
    (tmp_path / "system.json").write_text("{")
    with pytest.raises(ConfigError, match=r"system\.json"):
        read_system_file(tmp_path)


def test_a_dead_launcher_is_no_running_system(tmp_path: Path) -> None:
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    assert not is_running(system_file(tmp_path, ended.pid))


def test_waiting_ends_when_the_launcher_says_ready(tmp_path: Path) -> None:
    system = system_file(tmp_path, 4711)
    write_system_file(system)
    assert wait_until_ready(tmp_path, 4711, lambda: None) == system


def test_waiting_ignores_the_file_of_an_earlier_launcher(tmp_path: Path) -> None:
    write_system_file(system_file(tmp_path, 4711))
    with pytest.raises(ProcessError, match="not ready within 0 s"):
        wait_until_ready(tmp_path, 4712, lambda: None, patience_s=0.15)


def test_waiting_tells_why_the_launcher_gave_up(tmp_path: Path) -> None:
    broken = msgspec.structs.replace(
        system_file(tmp_path, 4711), state="stopping", detail="no robot"
    )
    write_system_file(broken)
    with pytest.raises(ProcessError, match="no robot"):
        wait_until_ready(tmp_path, 4711, lambda: None)


def test_waiting_tells_that_the_launcher_ended(tmp_path: Path) -> None:
    with pytest.raises(ProcessError, match="exit status 3"):
        wait_until_ready(tmp_path, 4711, lambda: 3)


def test_verbs_use_the_running_system_and_flags_win(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    run = tmp_path / "runs" / "x"
    run.mkdir(parents=True)
    (tmp_path / "runs" / "current").symlink_to(run)
    write_system_file(system_file(run, os.getpid()))
    assert service_config(Connection()).router == "tcp/127.0.0.1:1"
    assert service_config(Connection(router="tcp/10.0.0.1:7")).router == "tcp/10.0.0.1:7"


def test_without_a_system_the_error_says_how_to_start_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ConnectionFailedError, match="w2c up"):
        service_config(Connection())


def test_an_unknown_verb_suggests_the_nearest(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["stauts"]) == 2
    assert "did you mean 'status'" in capsys.readouterr().err


def test_every_listed_verb_exists() -> None:
    from importlib.metadata import entry_points

    verbs = {point.name for point in entry_points(group="w2c.commands")}
    listed = {name for names in cli.GROUPS.values() for name in names} - set(cli.SUBVERBS)
    assert listed <= verbs


def test_an_unknown_benchmark_names_the_known_ones(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["bench", "everything"]) == 2
    assert "demo" in capsys.readouterr().err


def test_help_costs_no_heavy_import() -> None:
    """`w2c --help` must not load torch, mujoco or pinocchio."""
    code = (
        "import sys; from w2c import cli; cli.main(['--help']);"
        "print([m for m in ('torch', 'mujoco', 'pinocchio', 'cv2') if m in sys.modules])"
    )
    answer = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert answer.stdout.strip().endswith("[]")


def test_a_step_clock_never_goes_back() -> None:
    clock = StepClock(10)
    clock.sleep_until(5)
    assert clock.now_ns() == 10
    with pytest.raises(ValueError, match="back"):
        clock.set(9)


def test_the_system_file_is_plain_json(tmp_path: Path) -> None:
    write_system_file(system_file(tmp_path, 1))
    assert msgspec.json.decode((tmp_path / "system.json").read_bytes())["robot"] == "talos"


@pytest.mark.parametrize("lines", [1, 20_000], ids=["a line that waits", "more than waits"])
def test_who_stops_reading_ends_a_verb_without_a_traceback(
    monkeypatch: pytest.MonkeyPatch, lines: int
) -> None:
    """As `w2c recording timeline FILE | head` does."""

    def run(*_: object) -> int:
        for _line in range(lines):
            sys.stdout.write("a line\n")
        return 0

    reader, writer = os.pipe()
    os.close(reader)
    with os.fdopen(writer, "w") as output:
        monkeypatch.setattr(sys, "stdout", output)
        monkeypatch.setattr(cli, "_run_verb", run)

        assert cli.main(["recording"]) == 1


def test_a_pipe_that_is_not_the_output_breaks_loudly(monkeypatch: pytest.MonkeyPatch) -> None:
    def run(*_: object) -> int:
        raise BrokenPipeError("a child's")

    monkeypatch.setattr(cli, "_run_verb", run)
    with pytest.raises(BrokenPipeError):
        cli.main(["recording"])
