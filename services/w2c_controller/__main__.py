"""`w2c controller`: the whole-body controller, a client of the robot driver."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from w2c import service
from w2c_controller.config import ControllerConfig

if TYPE_CHECKING:
    from w2c.bus import Bus
    from w2c.clock import Clock
    from w2c_controller.node import ControllerNode


def load_node() -> "Callable[[ControllerConfig, Bus, Clock], ControllerNode]":
    """Import the node, and with it Pinocchio."""
    from w2c_controller.node import ControllerNode

    return ControllerNode


def main(arguments: list[str] | None = None) -> int:
    """Run the controller. Returns the exit status."""
    return service.main(
        "controller",
        ControllerConfig,
        load_node,
        arguments,
        extra="controller",
        on_robot_host=True,
    )


if __name__ == "__main__":
    raise SystemExit(main())
