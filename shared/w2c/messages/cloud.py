"""Coloured points of what a frame shows."""

from typing import Annotated

import msgspec
import numpy as np

from w2c.messages.base import Array, Message, RobotBoot, Stamp, check_array

MAX_POINTS = 200_000
Corner = tuple[float, float, float]


class PointCloudRequest(Message, frozen=True, kw_only=True):
    """What stands in a box of the world, as a frame shows it?"""

    frame_stamp_ns: Stamp
    """Of a frame in the buffer of the last seconds"""
    low: Corner = (0.0, -1.0, -0.1)
    """Corner of the box with the smallest coordinates, in the world [m]"""
    high: Corner = (2.0, 1.0, 2.0)
    """The opposite corner [m]"""
    voxel: Annotated[float, msgspec.Meta(ge=0.001, le=0.5)] = 0.01
    """Points in one cube of this side become one, their mean [m]"""
    robot_boot_id: RobotBoot = ""
    """As in `LiftRequest`"""

    def __post_init__(self) -> None:
        """Refuse a box that is none."""
        sides = [high - low for low, high in zip(self.low, self.high, strict=True)]
        if not all(0.0 < side <= 100.0 for side in sides):
            raise ValueError(
                f"box from {self.low} to {self.high}: sides {sides}, expected above 0 to 100 m"
            )


class PointCloud(Message, frozen=True, kw_only=True):
    """Coloured points in the world."""

    stamp_ns: Stamp
    """Of the frame it was made from"""
    voxel: float
    """Side of the cubes of which each gave at most one point [m]"""
    points: Array
    """(n, 3) float32, in the world [m]"""
    colours: Array
    """(n, 3) uint8: red, green, blue"""

    def __post_init__(self) -> None:
        """Refuse arrays of the wrong shape, and clouds that are too large."""
        check_array("points", self.points, (None, 3), dtype=np.float32)
        check_array("colours", self.colours, (len(self.points), 3), dtype=np.uint8)
        if len(self.points) > MAX_POINTS:
            raise ValueError(f"{len(self.points)} points, expected {MAX_POINTS} at most")
