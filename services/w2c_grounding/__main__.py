"""`w2c grounding`: the process that finds phrases in pictures."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from w2c import service
from w2c.bus import Bus
from w2c.clock import Clock
from w2c_grounding.config import Config

if TYPE_CHECKING:
    from w2c_grounding.node import GroundingNode


def load_node() -> "Callable[[Config, Bus, Clock], GroundingNode]":
    """Import the node, and with it torch and transformers."""
    from w2c_grounding.node import GroundingNode

    return GroundingNode


def main(arguments: list[str] | None = None) -> int:
    """Run the process. Exit status: 0 done, 1 failed, 2 usage."""
    return service.main("grounding", Config, load_node, arguments, extra="grounding")


if __name__ == "__main__":
    raise SystemExit(main())
