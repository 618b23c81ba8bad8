"""Where in a picture a hand may go."""

from typing import Annotated

import msgspec
import numpy as np

from w2c.messages.base import Array, Message, Name, RobotBoot, Stamp, check_array

MAX_REASONS = 16


class AllowedAreaRequest(Message, frozen=True, kw_only=True):
    """Where in this frame is a surface that can carry a hand?"""

    frame_stamp_ns: Stamp
    """Of a frame in the buffer of the last seconds"""
    robot_boot_id: RobotBoot = ""
    """As in `LiftRequest`"""


class AllowedArea(Message, frozen=True, kw_only=True):
    """A coarse picture of where a hand may go, and of what forbids it elsewhere."""

    stamp_ns: Stamp
    """Of the frame it was made from"""
    width: int
    height: int
    """Of that frame [px]"""
    cells: Array
    """(rows, columns) uint8, covers the whole frame; 0 = allowed, k = `reasons[k - 1]` forbids"""
    reasons: Annotated[list[Name], msgspec.Meta(max_length=MAX_REASONS)]
    """For the operator"""

    def __post_init__(self) -> None:
        """Refuse cells without a reason."""
        check_array("cells", self.cells, (None, None), dtype=np.uint8)
        worst = int(self.cells.max(initial=0))
        if worst > len(self.reasons):
            raise ValueError(f"cells: reason {worst}, but there are {len(self.reasons)}")
