"""Which cells of a heatmap show what was asked for, and which of them is next to a point."""

import cv2
import numpy as np
import numpy.typing as npt

from w2c.messages import Array
from w2c_dialogue.cells import cell_at, middles
from w2c_dialogue.expressions import ImagePoint

HOT = 0.5
"""Of the peak: cells that show what was asked for"""
MARGIN = 0.008
"""From the edge of what is seen, as a share of the width of the picture"""


def hot(heatmap: Array) -> npt.NDArray[np.bool_]:
    """Return the cells (h, w) that show what was asked for; none of a cold heatmap."""
    return np.asarray((heatmap >= HOT * float(heatmap.max())) & (heatmap > 0))


def inner(cells: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Return the cells (h, w) that are not near the edge of the others."""
    width = max(1, round(MARGIN * cells.shape[1]))
    kernel = np.ones((2 * width + 1, 2 * width + 1), dtype=np.uint8)
    # What is seen goes on beyond the edge of the picture.
    kept = cv2.erode(cells.astype(np.uint8), kernel, borderType=cv2.BORDER_REPLICATE)
    return np.asarray(kept > 0)


def nearest(
    cells: npt.NDArray[np.bool_], point: ImagePoint, size: tuple[int, int]
) -> ImagePoint | None:
    """Return a point that is on one of the cells (h, w), else the middle of the nearest of them.

    Args:
        cells: Of a picture.
        point: In the picture [px].
        size: Width and height of the picture [px].

    Returns:
        None without any cell.
    """
    if cells[cell_at(point.u, point.v, cells.shape, size)]:
        return point
    if not cells.any():
        return None
    rows, columns = np.nonzero(cells)
    u, v = middles(rows, columns, cells.shape, size)
    index = int(np.argmin(np.hypot(u - point.u, v - point.v)))
    return ImagePoint(float(u[index]), float(v[index]), clipped=point.clipped)
