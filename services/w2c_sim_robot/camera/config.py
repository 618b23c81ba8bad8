"""The flags of `w2c camera`."""

from typing import Annotated

from msgspec import Meta

from w2c.config import ServiceConfig


class CameraConfig(ServiceConfig, frozen=True, kw_only=True):
    """The head camera of the simulated robot, and its photographers."""

    scene: str = ""
    """Scene file (JSON), the same that the robot was started with; empty = nothing but the
    floor."""
    rate: Annotated[float, Meta(ge=0.0, le=30.0)] = 3.0
    """Pictures of the stream [Hz]; 0 = only when asked for one."""
    width: Annotated[int, Meta(ge=64, le=1920)] = 1280
    """Of the pictures [px]."""
    height: Annotated[int, Meta(ge=64, le=1080)] = 720
    """Of the pictures [px]; the vertical field of view is the same for all."""
    depth: bool = True
    """Send depth with every picture of the stream."""
    depth_delay: Annotated[float, Meta(ge=0.0, le=0.5)] = 0.0
    """Perturbation: the stream's depth is of so long before its colours, and says so [s]."""
    shadows: bool = False
    """Draw shadows in the stream, too: three times the time."""
    antialiasing: bool = False
    """Smooth the stream's pictures, too: four times the pixels. Depth stays sharp."""
    jpeg_quality: Annotated[int, Meta(ge=10, le=100)] = 95
    """Of the pictures: 80 halves their bytes."""
