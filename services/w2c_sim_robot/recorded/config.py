"""The flags of `w2c recorded-robot`."""

from typing import Annotated

from msgspec import Meta

from w2c.driver.config import DriverConfig


class RecordedRobotConfig(DriverConfig, frozen=True, kw_only=True):
    """A recording that plays the robot, and the driver before it."""

    recording: str
    """MCAP file of a session, as the recorder writes it."""
    start: Annotated[float, Meta(ge=0.0)] = 0.0
    """Where to begin, since the first state of the recording [s]."""
    duration: Annotated[float, Meta(ge=0.0)] = 0.0
    """How much of it to play [s]; 0 = to its end. 15 minutes at most fit into memory."""
    repeat: bool = False
    """Begin again at the end; otherwise the robot stands still there."""
    lock_step: bool = False
    """Wait for the command of each tick instead of keeping real time."""
