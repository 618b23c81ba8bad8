"""What `w2c replay FILE --through SERVICE` is asked for.

`w2c_recorder.through.commands.run(path: Path, options: ThroughOptions) -> int` does it, and returns
the exit status: 0 = every output that was compared is equal, 1 = one is not, or none could be
compared. It raises RecordingError for a file without what the service needs, ConfigError for a
service that cannot be run on a recording.
"""

import math
from pathlib import Path

import msgspec


class ThroughOptions(msgspec.Struct, frozen=True, kw_only=True):
    """One service, and how closely its outputs must be the recorded ones."""

    service: str
    """Its name in the registry, as controller"""
    tolerance: float | None = None
    """Of each number, in its unit; None = what the service states for itself"""
    start_s: float = 0.0
    """Compare from this time of the timeline on [s]"""
    end_s: float = math.inf
    json: Path | None = None
    """Where to write the same as JSON; None = nowhere"""
