"""The verbs `up`, `down`, `status` and `doctor`."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import msgspec

from w2c import topics
from w2c.bus import Bus
from w2c.config import parse
from w2c.errors import ProcessError
from w2c.messages import Health
from w2c.service import stop_on_signals
from w2c.system import (
    CURRENT,
    Connection,
    is_running,
    read_system_file,
    service_config,
    wait_until_ready,
)

HEALTH_ROUND_S = 1.6
"""Every process reports once a second: this long shows them all."""


def up(arguments: list[str] | None = None) -> int:
    """Start a system and look after it."""
    from w2c_launcher.run_directory import make_run_directory
    from w2c_launcher.up import System, UpConfig

    argv = sys.argv[1:] if arguments is None else arguments
    config = parse(UpConfig, argv, program="w2c up")
    if not config.detach:
        return System(config, stop_on_signals()).run()
    run_directory = make_run_directory(config.run_directory)
    flags = [flag for flag in argv if flag not in ("--detach", "--no-detach")]
    with (run_directory / "launcher.log").open("ab") as log_file:
        launcher = subprocess.Popen(
            [sys.executable, "-m", "w2c.cli", "up", *flags, "--run-directory", str(run_directory)],
            stdin=subprocess.DEVNULL,
            stdout=log_file,
            stderr=log_file,
            start_new_session=True,
        )
    system = wait_until_ready(run_directory, launcher.pid, launcher.poll)
    print(f"ready; operator's page: {system.console_url}; stop it with: w2c down")
    return 0


class DownConfig(msgspec.Struct, frozen=True, kw_only=True):
    """Stop the running system, in order."""

    run_directory: str = str(CURRENT)
    """Of the system to stop."""
    timeout: float = 60.0
    """How long to wait for the end [s]."""


def down(arguments: list[str] | None = None) -> int:
    """Stop the running system. Exit status 0 also where none runs."""
    config = parse(DownConfig, arguments or [], program="w2c down")
    system = read_system_file(Path(config.run_directory))
    if system is None or not is_running(system):
        print("nothing runs here")
        return 0
    os.kill(system.pid, signal.SIGTERM)
    deadline = time.monotonic() + config.timeout
    while is_running(system):
        if time.monotonic() > deadline:
            raise ProcessError(
                f"launcher {system.pid} still runs after {config.timeout:.0f} s; "
                f"look at {system.run_directory}, or end it with: kill -9 {system.pid}"
            )
        time.sleep(0.05)
    print("stopped")
    return 0


class StatusConfig(Connection, frozen=True, kw_only=True):
    """Show the state of each process."""

    wait_for: tuple[str, ...] = ()
    """Services: exit 0 once all of them are ready, 1 after --patience."""
    patience: float = 0.0
    """How long to wait for --wait-for [s]."""


def status(arguments: list[str] | None = None) -> int:
    """Print a table of processes. Exit status 0 when all are ready, 1 otherwise."""
    from w2c.bus.zenoh_bus import connect

    config = parse(StatusConfig, arguments or [], program="w2c status")
    service = service_config(config)
    with connect(service, "operator", [service.router]) as bus:
        deadline = time.monotonic() + config.patience
        while True:
            reports = _collect_health(bus, HEALTH_ROUND_S)
            missing = [name for name in config.wait_for if not _is_ready(name, reports)]
            if not missing or time.monotonic() >= deadline:
                break
        alive = bus.alive()
    for name in topics.SERVICES:
        _print_row(name, [report for report in reports if report.service == name])
    absent = [name for name in topics.SERVICES if not _is_ready(name, reports)]
    if config.wait_for:
        return 1 if missing else 0
    if not alive:
        print("no process is alive on this bus")
    return 1 if absent else 0


def _collect_health(bus: Bus, seconds: float) -> list[Health]:
    """Return the newest report of each process that reports within this time."""
    queue = bus.queue(topics.HEALTH)
    newest: dict[tuple[str, str], Health] = {}
    deadline = time.monotonic() + seconds
    while (remaining := deadline - time.monotonic()) > 0:
        received = queue.receive(remaining)
        if received is not None:
            newest[received.message.service, received.message.instance] = received.message
    return list(newest.values())


def _is_ready(name: str, reports: list[Health]) -> bool:
    return any(report.service == name and report.phase == "ready" for report in reports)


def _print_row(name: str, reports: list[Health]) -> None:
    if not reports:
        print(f"{name:<11} absent")
    for report in reports:
        late = sum(n for cause, n in report.counters.items() if cause.startswith("late"))
        lost = sum(report.counters.values()) - late
        print(
            f"{name:<11} {report.phase:<10} pid {report.pid:<7} cpu {report.cpu_percent:5.1f} %  "
            f"memory {report.memory_mb:6.0f} MB  dropped or refused {lost}  "
            f"late {late}  {report.detail}"
        )


def doctor(arguments: list[str] | None = None) -> int:
    """Look at this machine and say what is missing. Exit status 0 = all that is needed."""
    from w2c_launcher.doctor import examine

    parse(DoctorConfig, arguments or [], program="w2c doctor")
    findings = examine()
    for finding in findings:
        mark = "ok  " if finding.ok else ("note" if finding.optional else "FAIL")
        print(f"{mark}  {finding.subject:<22} {finding.text}")
    return 0 if all(finding.ok or finding.optional for finding in findings) else 1


class DoctorConfig(msgspec.Struct, frozen=True, kw_only=True):
    """Look at this machine and say what is missing."""
