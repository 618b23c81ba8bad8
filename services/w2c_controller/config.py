"""The flags of `w2c controller`."""

from typing import Annotated

from msgspec import Meta

from w2c.config import ServiceConfig
from w2c.realtime import Setting


class ControllerConfig(ServiceConfig, frozen=True, kw_only=True):
    """The whole-body controller."""

    stale_ms: Annotated[float, Meta(ge=10.0, le=5000.0)] = 100.0
    """In real time, without a state for this long the controller stops commanding [ms]."""
    old_ms: Annotated[float, Meta(ge=1.0, le=5000.0)] = 50.0
    """In real time, a state that was on its way for longer is not used [ms]."""
    real_time: Setting = "auto"
    """In real time, ask for locked memory and SCHED_FIFO: on, off, or auto: from 4 cores on."""
