"""Cells of a heatmap, and the pixels of the picture that it covers."""

import numpy as np
import numpy.typing as npt


def middles(
    rows: npt.NDArray[np.int64],
    columns: npt.NDArray[np.int64],
    shape: tuple[int, ...],
    size: tuple[int, int],
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return where the middles of cells are in the picture (u, v) [px].

    Args:
        rows: Of the cells.
        columns: Of the same cells.
        shape: Of the heatmap (h, w).
        size: Width and height of the picture [px].
    """
    height, width = shape
    return (columns + 0.5) * size[0] / width, (rows + 0.5) * size[1] / height


def cell_at(u: float, v: float, shape: tuple[int, ...], size: tuple[int, int]) -> tuple[int, int]:
    """Return the (row, column) of the cell over a pixel; the nearest one outside the picture.

    Args:
        u: To the right [px].
        v: Down [px].
        shape: Of the heatmap (h, w).
        size: Width and height of the picture [px].
    """
    height, width = shape
    row, column = int(v * height / size[1]), int(u * width / size[0])
    return min(max(row, 0), height - 1), min(max(column, 0), width - 1)
