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
    state_rate: Annotated[float, Meta(ge=5.0, le=500.0)] = 100.0
    """How often joint angles are taken from the stream of states [Hz]"""
