"""`w2c console`: serve the operator's page."""

from collections.abc import Callable

from w2c import service
from w2c.bus import Bus
from w2c.clock import Clock
from w2c_console.config import ConsoleConfig


def load_node() -> Callable[[ConsoleConfig, Bus, Clock], service.Node]:
    """Return the node's class; imports the web server."""
    from w2c_console.node import ConsoleNode

    return ConsoleNode


def main(arguments: list[str] | None = None) -> int:
    """Run the console from its flags. Returns the exit status."""
    return service.main("console", ConsoleConfig, load_node, arguments, extra="console")


if __name__ == "__main__":
    raise SystemExit(main())
