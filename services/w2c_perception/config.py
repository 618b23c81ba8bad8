"""The flags of `w2c perception`."""

from typing import Annotated

from msgspec import Meta

from w2c.config import ServiceConfig


class PerceptionConfig(ServiceConfig, frozen=True, kw_only=True):
    """The memory of the last pictures, and where the camera was when they were taken."""

    history: Annotated[float, Meta(gt=0.0, le=600.0)] = 60.0
    """How long a picture is remembered, robot time [s]: longer than the slowest answer of a
    language model"""
    max_frames: Annotated[int, Meta(ge=1, le=10_000)] = 200
    """Pictures remembered at most; each takes up to 1 MB"""
    unpacked_frames: Annotated[int, Meta(ge=1, le=1000)] = 6
    """Pictures whose depth is kept unpacked, those that were asked about last; each takes 2 MB"""
    state_rate: Annotated[float, Meta(ge=5.0, le=500.0)] = 100.0
    """How often joint angles are taken from the stream of states [Hz]"""
    joint_error: Annotated[float, Meta(ge=0.0, le=0.1)] = 0.00087
    """Constant error that each joint angle may have [rad], 0.05 degrees: goes into the error bound
    of what is said of the world"""
    depth_lag: Annotated[float, Meta(ge=0.0, le=1.0)] = 0.0
    """How far apart in time colour and depth of one picture may be [s]; the simulated camera draws
    both at once"""
