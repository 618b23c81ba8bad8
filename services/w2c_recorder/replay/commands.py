"""The verb `replay`: a recording onto the bus, or `--through` one service."""

import sys

from w2c.extras import needs_extra
from w2c_recorder.replay.options import parse_options
from w2c_recorder.through.options import ThroughOptions


def replay(arguments: list[str] | None = None) -> int:
    """Play a recording. Status 1 where `--through` found a difference, or nothing was played."""
    path, options = parse_options(list(sys.argv[1:] if arguments is None else arguments))
    with needs_extra("recorder"):
        if isinstance(options, ThroughOptions):
            from w2c_recorder.through.commands import run

            return run(path, options)
        from w2c_recorder.replay.run import play_on_bus

        report = play_on_bus(path, options)
    for line in report.lines:
        print(line)
    return report.status
