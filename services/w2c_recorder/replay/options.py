"""Flags of `w2c replay FILE`, and of `w2c replay FILE --through SERVICE`."""

import argparse
import math
from pathlib import Path
from typing import Annotated, Any

import msgspec

from w2c.config import RobotId, load
from w2c.errors import ConfigError
from w2c_recorder.flags import seconds
from w2c_recorder.through.options import ThroughOptions

FASTEST = 1000.0
ONLY_THROUGH = {"service": "--through", "tolerance": "--tolerance", "json": "--json"}
"""Fields of ThroughOptions that playing on the bus does not have, and their flags"""
FOR_BOTH = ("start_s", "end_s")


class ReplayOptions(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What to play on the bus, how, and where."""

    namespace: RobotId = "replay"
    """In the place of the robot's id on every key."""
    speed: Annotated[float, msgspec.Meta(gt=0, le=FASTEST)] = 1.0
    """1 = as it was."""
    start_s: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    """Time of the timeline [s]."""
    end_s: Annotated[float, msgspec.Meta(ge=0)] | None = None
    """Time of the timeline [s]; None = the end."""
    loop: bool = False
    """Begin again at the end."""
    include: tuple[str, ...] = ("*",)
    """Patterns of KIND/SERVICE/NAME; a key is played that fits one of them ..."""
    exclude: tuple[str, ...] = ()
    """... and none of these."""
    with_commands: bool = False
    """Play joint commands, too."""
    router: str = ""
    """Endpoint; empty = that of the running system."""
    timeout: Annotated[float, msgspec.Meta(gt=0)] = 3.0
    """How long to try to connect [s]."""


def make_parser() -> argparse.ArgumentParser:
    """Return the parser. What is not given is not in its result: the structs have the defaults."""
    parser = argparse.ArgumentParser(
        prog="w2c replay",
        description="Play a recording on the bus under a robot's id of its own, where "
        "robot/describe is answered as it was and no other call; or --through one "
        "service, to see whether it answers as it did.",
        argument_default=argparse.SUPPRESS,
        allow_abbrev=False,
    )
    parser.add_argument("file", type=Path, help="an MCAP file; of a rotated series the first")
    parser.add_argument(
        "--from", dest="start_s", type=seconds, metavar="T", help="as in the timeline: 75.2, 1:15.2"
    )
    parser.add_argument("--until", dest="end_s", type=seconds, metavar="T", help="the same")
    bus = parser.add_argument_group("on the bus")
    bus.add_argument(
        "--as", dest="namespace", metavar="NAME", help="the robot's id on the keys (replay)"
    )
    bus.add_argument("--speed", type=float, metavar="X", help="1 = as it was, 4 = four times")
    bus.add_argument("--loop", action="store_true", help="begin again at the end")
    for flag, text in (
        ("--include", "play only keys that fit: 'state/*', log/llm/record"),
        ("--exclude", "leave these out"),
    ):
        bus.add_argument(flag, action="append", metavar="KIND/SERVICE/NAME", help=text)
    bus.add_argument("--with-commands", action="store_true", help="joint commands, too")
    bus.add_argument("--router", metavar="ENDPOINT", help="where no system runs here")
    bus.add_argument("--timeout", type=float, metavar="S", help="to connect [s] (3)")
    through = parser.add_argument_group("through one service")
    through.add_argument(
        "--through", dest="service", metavar="SERVICE", help="run it on its recorded inputs"
    )
    through.add_argument("--tolerance", type=float, metavar="X", help="of each number, in its unit")
    through.add_argument("--json", type=Path, metavar="FILE", help="write the same as JSON")
    return parser


def parse_options(arguments: list[str]) -> tuple[Path, ReplayOptions | ThroughOptions]:
    """Return the file and what to do with it. Raises ConfigError."""
    values = vars(make_parser().parse_args(arguments))
    path: Path = values.pop("file")
    if "service" in values:
        return path, _through_options(values)
    for name, flag in ONLY_THROUGH.items():
        if name in values:
            raise ConfigError(f"{flag} goes with --through SERVICE")
    for patterns in ("include", "exclude"):
        if patterns in values:
            values[patterns] = tuple(values[patterns])
    options = load(ReplayOptions, values)
    _check_times(options.start_s, math.inf if options.end_s is None else options.end_s)
    return path, options


def _through_options(values: dict[str, Any]) -> ThroughOptions:
    """Return the options of a replay through one service. Raises ConfigError."""
    for name in values:
        if name not in ONLY_THROUGH and name not in FOR_BOTH:
            flag = "--as" if name == "namespace" else f"--{name.replace('_', '-')}"
            raise ConfigError(f"{flag} is for a replay on the bus; --through SERVICE needs none")
    options = ThroughOptions(**values)
    if options.tolerance is not None and not 0.0 <= options.tolerance < math.inf:
        raise ConfigError(
            f"--tolerance {options.tolerance:g}: a difference of numbers is 0 or more, as 1e-6"
        )
    _check_times(options.start_s, options.end_s)
    return options


def _check_times(start_s: float, end_s: float) -> None:
    """Raise ConfigError where nothing is between two times [s]."""
    if end_s <= start_s:
        raise ConfigError(f"--until {end_s:g} is not after --from {start_s:g}; nothing is between")
