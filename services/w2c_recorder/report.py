"""What an action on a recording gives: lines for people, values for programs, an exit status."""

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


def write_file(path: Path, data: bytes) -> None:
    """Write a file, with the directories above it. Raises ConfigError."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    except OSError as error:
        raise ConfigError(
            f"{path} cannot be written: {error.strerror}; choose another place"
        ) from error
