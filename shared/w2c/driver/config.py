"""The flags that the drivers of all robots have."""

from typing import Annotated

from msgspec import Meta

from w2c.config import ServiceConfig
from w2c.realtime import Setting


class DriverConfig(ServiceConfig, frozen=True, kw_only=True):
    """What a driver is told of its loop."""

    real_time: Setting = "auto"
    """In real time, ask for locked memory and SCHED_FIFO: on, off, or auto: from 4 cores on."""
    watchdog_ms: Annotated[float, Meta(ge=2.0, le=10_000.0)] = 50.0
    """The driver holds when the newest command answers a state older than this, robot time [ms]."""
