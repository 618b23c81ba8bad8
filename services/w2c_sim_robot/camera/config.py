"""The flags of `w2c camera`."""

from typing import Annotated

from msgspec import Meta

from w2c.config import ServiceConfig


class CameraConfig(ServiceConfig, frozen=True, kw_only=True):
    """The head camera of the simulated robot, and its photographers."""

    scene: str = ""
    """Scene file (JSON), the same that the robot was started with; empty = nothing but the
    floor."""
    rate: Annotated[float, Meta(gt=0.0, le=30.0)] = 3.0
    """Pictures of the stream [Hz]"""
