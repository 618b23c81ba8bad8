"""The driver of a robot, but for the robot: what owns the hub, the pace, the watchdog and stop.

Behind it is a `Machine`: a simulator, a recording, or a real robot. See docs/how-to/own-robot.md.
"""

from w2c.driver.config import DriverConfig
from w2c.driver.driver import Driver, main
from w2c.driver.machine import Machine

__all__ = ["Driver", "DriverConfig", "Machine", "main"]
