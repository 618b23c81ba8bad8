"""`w2c up`: from flags to a running system, and back to nothing."""

import logging
import os
import shlex
import threading
import time
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import msgspec

from w2c.bus.zenoh_bus import ZenohBus, connect
from w2c.config import RobotId, ServiceConfig
from w2c.errors import ConfigError, ConnectionFailedError, ProcessError
from w2c.library import library
from w2c.logs import configure_logs
from w2c.system import CURRENT, SystemFile, is_running, read_system_file, write_system_file
from w2c_launcher.launcher import Launcher
from w2c_launcher.ports import free_port, require_free
from w2c_launcher.profiles import Options, processes
from w2c_launcher.run_directory import make_run_directory, point_current_to

log = logging.getLogger("w2c.launcher")


class UpConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Start the processes of a profile and look after them until Ctrl-C or `w2c down`."""

    profile: str = "simulation"
    """simulation, robot (robot and controller run elsewhere) or gpu-host (llm and grounding)."""
    robot: RobotId = "talos"
    """Id of the robot."""
    router: str = "tcp/127.0.0.1:7447"
    """Endpoint of the router."""
    robot_endpoint: str = "tcp/127.0.0.1:7448"
    """Endpoint of the robot driver."""
    console_port: Annotated[int, msgspec.Meta(ge=1, le=65535)] = 8080
    """Port of the operator's page."""
    private: bool = False
    """Use free ports and leave `runs/current` alone: for tests and benchmarks."""
    lock_step: bool = False
    """The simulator waits for each command instead of keeping real time."""
    scene: str = ""
    """Scene of the simulator: a file (.json), scenario_a to scenario_e, or random (both drawn from
    --seed); empty = scenario (a) of the paper, as in the demo."""
    seed: Annotated[int, msgspec.Meta(ge=0)] = 0
    """Of the simulator's noise."""
    run_directory: str = ""
    """Where logs and the recording go; empty = runs/<date and time>."""
    services: str = ""
    """TOML file with a table a service, for all settings that are not flags here."""
    with_flags: tuple[str, ...] = ()
    """More flags for one service, e.g. --with-flags "llm:--model my.gguf"; quoted as in a shell."""
    without: tuple[str, ...] = ()
    """Services that are not started: something else answers for them, or nobody."""
    detach: bool = False
    """Return as soon as everything is ready, and leave it running."""


def options_of(config: UpConfig, run_directory: Path) -> Options:
    """Return the options of the profile; private ones get free ports."""
    extra: dict[str, tuple[str, ...]] = {}
    for entry in config.with_flags:
        service, separator, flags = entry.partition(":")
        if not separator:
            raise ConfigError(f"--with-flags '{entry}': expected SERVICE:FLAGS")
        try:
            words = shlex.split(flags)
        except ValueError as error:  # a quote that is not closed
            raise ConfigError(
                f"--with-flags '{entry}' has a quote that is not closed; close it"
            ) from error
        extra[service] = (*extra.get(service, ()), *words)
    return Options(
        robot=config.robot,
        router=f"tcp/127.0.0.1:{free_port()}" if config.private else config.router,
        robot_endpoint=f"tcp/127.0.0.1:{free_port()}" if config.private else config.robot_endpoint,
        run_directory=str(run_directory),
        console_port=free_port() if config.private else config.console_port,
        lock_step=config.lock_step,
        scene=config.scene,
        seed=config.seed,
        config=str(Path(config.services).resolve()) if config.services else "",
        extra_flags=extra,
        without=config.without,
    )


def with_scene(options: Options, profile: str) -> Options:
    """Return the options with a scene file for the simulator: scenario (a), where none was chosen.

    Raises:
        ConfigError: neither a file nor a name of a scene.
    """
    is_file = options.scene.endswith(".json") or Path(options.scene).is_file()
    if (options.scene and is_file) or profile != "simulation":
        return replace(options, scene=str(Path(options.scene).resolve()) if options.scene else "")
    path = Path(options.run_directory) / "scene.json"
    scene = library("named_scene")(
        options.scene or "scenario_a", options.seed if options.scene else 0
    )
    library("save_scene")(scene, path)
    return replace(options, scene=str(path))


class System:
    """One run of `w2c up`."""

    def __init__(self, config: UpConfig, stop: threading.Event) -> None:
        self._config = config
        self._stop = stop
        self._started = time.monotonic()
        if not config.private:
            self._refuse_second()
        self._run_directory = make_run_directory(config.run_directory)
        self._options = with_scene(options_of(config, self._run_directory), config.profile)
        self._launcher = Launcher(
            processes(config.profile, self._options), self._run_directory, self._show
        )

    def run(self) -> int:
        """Start, watch, stop. Returns the exit status."""
        configure_logs("launcher", "info", str(self._run_directory))
        if not self._config.private:
            require_free(self._options.router, "--router")
            require_free(self._options.robot_endpoint, "--robot-endpoint")
            require_free(f"tcp/127.0.0.1:{self._options.console_port}", "--console-port")
            point_current_to(self._run_directory)
        self._write("starting")
        status = 0
        with ExitStack() as stack:
            try:
                self._start(stack)
                self._watch()
            except ProcessError as error:
                log.error("%s", error)
                self._write("stopping", str(error))
                status = 1
            finally:
                self._write("stopping")
                self._launcher.stop()
                self._write("stopped")
        return status

    def _start(self, stack: ExitStack) -> None:
        self._launcher.start_stage(0)
        self._launcher.attach(stack.enter_context(self._connect()))
        for stage in (0, 1, 2):
            if stage > 0:
                self._launcher.start_stage(stage)
            self._launcher.wait_ready(stage, self._stop.is_set)
        if not self._stop.is_set():
            self._write("ready")
            seconds = time.monotonic() - self._started
            log.info("ready after %.1f s; operator's page: %s", seconds, self._console_url)

    def _connect(self) -> ZenohBus:
        config = ServiceConfig(
            robot=self._options.robot, router=self._options.router, connect_timeout=20.0
        )
        try:
            return connect(config, "launcher", [config.router])
        except ConnectionFailedError as error:
            raise ProcessError(f"the router does not answer: {error}") from error

    def _watch(self) -> None:
        ready, shown = True, 0.0
        while not self._stop.is_set():
            self._launcher.watch()
            if self._launcher.all_ready != ready:
                ready = not ready
                self._write("ready" if ready else "degraded")
            if time.monotonic() - shown > 1.0:
                shown = time.monotonic()
                self._launcher.publish()

    def _refuse_second(self) -> None:
        running = read_system_file(CURRENT)
        if running is not None and is_running(running):
            raise ConfigError(
                f"a system runs already (launcher {running.pid}, {running.run_directory}). "
                "Stop it with: w2c down. Or start a second one with: w2c up --private"
            )

    @property
    def _console_url(self) -> str:
        return f"http://127.0.0.1:{self._options.console_port}"

    def _show(self, name: str, text: str) -> None:
        log.info("%-11s %s", name, text)

    def _write(self, state: str, detail: str = "") -> None:
        values = {
            "state": state,
            "pid": os.getpid(),
            "robot": self._options.robot,
            "router": self._options.router,
            "robot_endpoint": self._options.robot_endpoint,
            "console_url": self._console_url,
            "run_directory": str(self._run_directory),
            "profile": self._config.profile,
            "detail": detail,
        }
        write_system_file(msgspec.convert(values, SystemFile))
