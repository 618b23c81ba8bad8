"""The flags of `w2c robot`."""

from typing import Annotated

from msgspec import Meta

from w2c.config import ServiceConfig
from w2c.realtime import Setting

Scale = Annotated[float, Meta(ge=0.05, le=20.0)]


class RobotConfig(ServiceConfig, frozen=True, kw_only=True):
    """The simulated robot and its driver."""

    lock_step: bool = False
    """Wait for the command of each tick instead of keeping real time."""
    real_time: Setting = "auto"
    """In real time, ask for locked memory and SCHED_FIFO: on, off, or auto: from 4 cores on."""
    scene: str = ""
    """Scene file (JSON) of what stands before the robot; empty = nothing but the floor."""
    seed: int = 0
    """Of the sensor noise."""
    watchdog_ms: Annotated[float, Meta(ge=2.0, le=10_000.0)] = 50.0
    """The driver holds when the newest command answers a state older than this, robot time [ms]."""
    truth_every: Annotated[int, Meta(ge=1)] = 10
    """In lock step, publish `truth` every so many ticks; in real time it goes out at 30 Hz."""
    noise: Annotated[float, Meta(ge=0.0, le=100.0)] = 0.0
    """Sensor noise: 0 = none, 1 = of ordinary sensors."""
    stiffness_scale: Scale = 1.0
    """True joint stiffness over the described one."""
    friction_scale: Scale = 1.0
    """Of feet and hands; 1 = coefficient 0.8."""
    mass_scale: Scale = 1.0
    """True masses over the described ones."""
