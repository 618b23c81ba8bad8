"""What stands around the robot, as seen from above."""

from typing import Annotated

import msgspec
import numpy as np

from w2c.messages.base import Array, Message, RobotBoot, Stamp

MAX_CELLS = 40_000


class HeightFieldRequest(Message, frozen=True, kw_only=True):
    """How high is what this frame shows?"""

    frame_stamp_ns: Stamp
    """Of a frame in the buffer of the last seconds"""
    robot_boot_id: RobotBoot = ""
    """As in `LiftRequest`"""


class HeightField(Message, frozen=True, kw_only=True):
    """The highest point seen in each cell of a grid over the floor, without the robot's arms."""

    stamp_ns: Stamp
    """Of the frame it was made from"""
    origin: tuple[float, float]
    """x and y of the corner of cell [0, 0] with the smallest of both, in the world [m]"""
    cell: Annotated[float, msgspec.Meta(ge=0.005, le=0.2)]
    """Side of a cell [m]"""
    heights: Array
    """(rows, columns) float32, in the world [m]; rows along x, columns along y; NaN = unseen"""

    def __post_init__(self) -> None:
        """Refuse grids that are too large, and heights that no room has."""
        heights = self.heights
        if heights.dtype != np.float32 or heights.ndim != 2:
            raise ValueError(
                f"heights: {heights.dtype} of {heights.ndim} dimensions, expected float32 of 2"
            )
        if not 0 < heights.size <= MAX_CELLS:
            raise ValueError(f"heights: {heights.size} cells, expected 1 to {MAX_CELLS}")
        if not np.isfinite(self.origin).all() or max(abs(value) for value in self.origin) > 10.0:
            raise ValueError(f"origin: {self.origin}, expected finite and within 10 m")
        # NaN compares false with everything: unseen cells pass.
        if (np.abs(heights) > 10.0).any():
            raise ValueError("heights: beyond 10 m, expected metres above the floor")
