"""`w2c perception`: pixel and frame stamp in, point and normal in the world out."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from w2c import service
from w2c_perception.config import PerceptionConfig

if TYPE_CHECKING:
    from w2c.bus import Bus
    from w2c.clock import Clock
    from w2c_perception.node import PerceptionNode


def load_node() -> "Callable[[PerceptionConfig, Bus, Clock], PerceptionNode]":
    """Import the node, and with it Pinocchio."""
    from w2c_perception.node import PerceptionNode

    return PerceptionNode


def main(arguments: list[str] | None = None) -> int:
    """Run perception. Returns the exit status."""
    return service.main("perception", PerceptionConfig, load_node, arguments, extra="perception")


if __name__ == "__main__":
    raise SystemExit(main())
