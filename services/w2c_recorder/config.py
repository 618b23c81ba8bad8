"""Flags and configuration of the recorder."""

from typing import Annotated, Literal

import msgspec

from w2c.config import ServiceConfig

Compression = Literal["lz4", "zstd", "none"]


class RecorderConfig(ServiceConfig, frozen=True, kw_only=True):
    """Configuration of the recorder."""

    autostart: bool = True
    """Record into the run directory from the start; without it, wait for `w2c record start`."""
    compression: Compression = "lz4"
    """Of the chunks. zstd makes smaller files for more processor time."""
    foxglove: bool = True
    """Write images, transforms, joint states, logs and targets once more for Foxglove and Rerun."""
    queue_size: Annotated[int, msgspec.Meta(ge=100, le=1_000_000)] = 20_000
    """Messages that may wait for the disk: 15 s of a running robot. More is dropped and counted."""
    rotate_mb: Annotated[float, msgspec.Meta(ge=0)] = 2000.0
    """A file that is larger is closed and the next one begins [MB]; 0 = never."""
    rotate_minutes: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    """The same for one that is older [min]; 0 = never."""
    minimum_free_mb: Annotated[float, msgspec.Meta(ge=0)] = 200.0
    """The recording stops when less is free on its disk [MB]."""
