"""`w2c robot`: the simulated robot and its driver, the hub of the robot host."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from w2c import service
from w2c_sim_robot.config import RobotConfig

if TYPE_CHECKING:
    from w2c.bus import Bus
    from w2c.clock import Clock
    from w2c_sim_robot.node import RobotNode


def load_node() -> "Callable[[RobotConfig, Bus, Clock], RobotNode]":
    """Import the node, and with it MuJoCo."""
    from w2c_sim_robot.node import RobotNode

    return RobotNode


def main(arguments: list[str] | None = None) -> int:
    """Run the robot. Returns the exit status."""
    return service.main("robot", RobotConfig, load_node, arguments, extra="sim-robot", hub=True)


if __name__ == "__main__":
    raise SystemExit(main())
