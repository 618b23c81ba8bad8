"""Pure functions that services offer to studies and set-up, found by entry point, not by import."""

from importlib.metadata import entry_points
from typing import Any

from w2c.errors import ConfigError

GROUP = "w2c.library"


def library(name: str) -> Any:
    """Return the function that a service registered under this name. Raises ConfigError."""
    points = {point.name: point for point in entry_points(group=GROUP)}
    if name not in points:
        raise ConfigError(
            f"no installed service offers '{name}' (known: {', '.join(sorted(points))}); "
            "install again with: make setup"
        )
    return points[name].load()
