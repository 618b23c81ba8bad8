"""Which processes run where, as data."""

from dataclasses import dataclass, field, replace

from w2c.errors import ConfigError


@dataclass(frozen=True)
class ProcessSpec:
    """One process to start."""

    name: str
    """Of the service on the bus, and of the verb that starts it"""
    flags: tuple[str, ...] = ()
    stage: int = 2
    """Processes of a stage start together, once all of the stage before are ready"""
    stop_stage: int = 0
    """Processes stop in ascending order of this"""
    joins_bus: bool = True
    """False: no health reports (the router)"""
    niceness: int = 0
    """How far it gives way to the others where the cores do not suffice"""


CAN_WAIT = 3
"""Niceness of what answers people. The loop, the robot, what carries their messages and what
records them go before: ten programs that load at once leave too little for what comes at 500 Hz."""


@dataclass(frozen=True)
class Options:
    """What the operator chose."""

    robot: str
    router: str
    robot_endpoint: str
    run_directory: str
    console_port: int
    lock_step: bool = False
    scene: str = ""
    seed: int = 0
    config: str = ""
    extra_flags: dict[str, tuple[str, ...]] = field(default_factory=dict)
    """Service -> more flags, e.g. an own model for llm"""
    without: tuple[str, ...] = ()
    """Services that are not started"""


def _connection(options: Options) -> tuple[str, ...]:
    flags = (
        *("--robot", options.robot, "--router", options.router),
        *("--robot-endpoint", options.robot_endpoint, "--run-directory", options.run_directory),
    )
    return (*flags, "--config", options.config) if options.config else flags


def _router(options: Options) -> ProcessSpec:
    flags = ("--listen", options.router)
    return ProcessSpec("router", flags, stage=0, stop_stage=9, joins_bus=False)


def _robot(options: Options) -> list[ProcessSpec]:
    scene = ("--scene", options.scene) if options.scene else ()
    lock_step = ("--lock-step",) if options.lock_step else ()
    common = _connection(options)
    return [
        ProcessSpec("robot", (*common, *scene, *lock_step, "--seed", str(options.seed)), 1, 7),
        ProcessSpec("controller", common, 2, 6),
        ProcessSpec("camera", (*common, *scene), 2, 5, niceness=CAN_WAIT),
    ]


def _models(options: Options) -> list[ProcessSpec]:
    return [
        ProcessSpec(name, _connection(options), 2, 4, niceness=CAN_WAIT)
        for name in ("llm", "grounding")
    ]


def _operator(options: Options) -> list[ProcessSpec]:
    common = _connection(options)
    console = (*common, "--port", str(options.console_port))
    return [
        ProcessSpec("recorder", common, 1, 8),
        ProcessSpec("perception", common, 2, 3, niceness=CAN_WAIT),
        ProcessSpec("dialogue", common, 2, 2, niceness=CAN_WAIT),
        ProcessSpec("console", console, 2, 1, niceness=CAN_WAIT),
    ]


PROFILES = {
    "simulation": lambda o: [_router(o), *_robot(o), *_models(o), *_operator(o)],
    # Robot and controller belong to the robot host's own supervision: they outlive any launcher.
    "robot": lambda o: [_router(o), *_models(o), *_operator(o)],
    "gpu-host": _models,
}
"""Profile -> its processes. In the robot profile, robot and controller are never our children."""


def processes(profile: str, options: Options) -> list[ProcessSpec]:
    """Return the processes of a profile. Raises ConfigError for an unknown profile or service."""
    if profile not in PROFILES:
        raise ConfigError(f"no profile '{profile}'; choose one of: {', '.join(PROFILES)}")
    specs = PROFILES[profile](options)
    names = [spec.name for spec in specs]
    unknown = [name for name in options.without if name not in names]
    if unknown:
        raise ConfigError(
            f"--without {unknown[0]}: profile '{profile}' does not start that; it starts: "
            f"{', '.join(names)}"
        )
    return [
        replace(spec, flags=(*spec.flags, *options.extra_flags.get(spec.name, ())))
        for spec in specs
        if spec.name not in options.without
    ]
