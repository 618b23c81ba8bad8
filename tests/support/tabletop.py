"""A table with boxes as the height field that perception would make of it."""

import numpy as np

from w2c.messages import HeightField

CELL = 0.02
ORIGIN = (0.1, -1.0)
TABLE = 0.8
"""Height of the table [m]"""


def table(*boxes: tuple[float, float, float, float, float]) -> HeightField:
    """Return a table from x = 0.4 on, with boxes (x, y, length, width, height of the top)."""
    heights = np.full((80, 100), np.nan, np.float32)
    heights[15:, :] = TABLE
    for x, y, length, width, top in boxes:
        rows = slice(
            *(round((edge - ORIGIN[0]) / CELL) for edge in (x - length / 2, x + length / 2))
        )
        columns = slice(
            *(round((edge - ORIGIN[1]) / CELL) for edge in (y - width / 2, y + width / 2))
        )
        heights[rows, columns] = top
    return HeightField(stamp_ns=0, origin=ORIGIN, cell=CELL, heights=heights)
