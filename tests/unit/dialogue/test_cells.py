"""Cells of a heatmap and pixels of its picture."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from w2c.messages import Box
from w2c_dialogue.cells import cell_at, middles
from w2c_dialogue.sight import inside

SIDES = st.integers(1, 2000)


@given(st.data(), SIDES, SIDES, SIDES, SIDES)
def test_the_middle_of_a_cell_is_in_that_cell(
    data: st.DataObject, rows: int, columns: int, width: int, height: int
) -> None:
    row = data.draw(st.integers(0, rows - 1))
    column = data.draw(st.integers(0, columns - 1))

    u, v = middles(np.array([row]), np.array([column]), (rows, columns), (width, height))

    assert cell_at(float(u[0]), float(v[0]), (rows, columns), (width, height)) == (row, column)


@pytest.mark.parametrize(
    ("pixel", "cell"),
    [((0.0, 0.0), (0, 0)), ((99.0, 1.0), (0, 9)), ((-20.0, 51.0), (4, 0)), ((1e6, 1e6), (4, 9))],
)
def test_a_pixel_outside_the_picture_has_the_nearest_cell(
    pixel: tuple[float, float], cell: tuple[int, int]
) -> None:
    assert cell_at(*pixel, (5, 10), (100, 50)) == cell


def test_of_two_boxes_side_by_side_one_has_the_line_between_them() -> None:
    left = Box(left=10.0, top=0.0, right=20.0, bottom=10.0, score=1.0)
    right = Box(left=20.0, top=0.0, right=30.0, bottom=10.0, score=1.0)

    assert not inside((20.0, 5.0), left)
    assert inside((20.0, 5.0), right)
    assert not inside((25.0, 10.0), right)
