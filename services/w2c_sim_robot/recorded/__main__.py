"""`w2c recorded-robot`: a recorded session in the place of a robot."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from w2c import driver
from w2c_sim_robot.recorded.config import RecordedRobotConfig

if TYPE_CHECKING:
    from w2c_sim_robot.recorded.machine import RecordedRobot


def load_machine() -> "Callable[[RecordedRobotConfig], RecordedRobot]":
    """Import the machine."""
    import mcap.reader  # noqa: F401 - said to be missing now, not when the file is opened

    from w2c_sim_robot.recorded.machine import open_recorded_robot

    return open_recorded_robot


def main(arguments: list[str] | None = None) -> int:
    """Run the driver. Returns the exit status."""
    return driver.main(
        RecordedRobotConfig, load_machine, arguments, extra="recorder", verb="recorded-robot"
    )


if __name__ == "__main__":
    raise SystemExit(main())
