"""What an action on a recording gives: lines for people, values for programs, an exit status."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from w2c.errors import ConfigError


@dataclass(frozen=True)
class Report:
    """The same twice."""

    lines: list[str]
    values: dict[str, Any] = field(default_factory=dict)
    status: int = 0


def spare(recording: Iterable[Path], *written: Path | None) -> None:
    """Raise ConfigError where a file that is to be written is one of the recording that is read."""
    for path in written:
        if path is not None and path.exists() and any(path.samefile(one) for one in recording):
            raise ConfigError(f"{path} is the recording itself; choose another place to write to")


def write_file(path: Path, data: bytes) -> None:
    """Write a file, with the directories above it. Raises ConfigError."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    except OSError as error:
        raise ConfigError(
            f"{path} cannot be written: {error.strerror}; choose another place"
        ) from error
