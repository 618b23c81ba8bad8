"""`w2c camera`: pictures with depth from the robot's head, and of the robot from outside."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from w2c import service
from w2c_sim_robot.camera.config import CameraConfig

if TYPE_CHECKING:
    from w2c.bus import Bus
    from w2c.clock import Clock
    from w2c_sim_robot.camera.node import CameraNode


def load_node() -> "Callable[[CameraConfig, Bus, Clock], CameraNode]":
    """Find a way to draw without a display, then import the node, and with it MuJoCo."""
    from w2c_sim_robot.camera.gl import choose_backend

    choose_backend()
    from w2c_sim_robot.camera.node import CameraNode

    return CameraNode


def main(arguments: list[str] | None = None) -> int:
    """Run the camera. Returns the exit status."""
    return service.main(
        "camera", CameraConfig, load_node, arguments, extra="sim-robot", on_robot_host=True
    )


if __name__ == "__main__":
    raise SystemExit(main())
