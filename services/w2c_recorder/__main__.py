"""`w2c recorder`: record everything on the bus into the run directory."""

from collections.abc import Callable

from w2c import service
from w2c.bus import Bus
from w2c.clock import Clock
from w2c_recorder.config import RecorderConfig


def load_node() -> Callable[[RecorderConfig, Bus, Clock], service.Node]:
    """Import the node, and with it mcap."""
    from w2c_recorder.node import RecorderNode

    return RecorderNode


def main(arguments: list[str] | None = None) -> int:
    """Run the recorder. Returns the exit status."""
    return service.main("recorder", RecorderConfig, load_node, arguments, extra="recorder")


if __name__ == "__main__":
    raise SystemExit(main())
