"""Cells that show something, away from its edge, next to a point."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from w2c_dialogue.cells import cell_at
from w2c_dialogue.expressions import ImagePoint
from w2c_dialogue.heat import HOT, MARGIN, hot, inner, nearest

SIZE = (640, 360)
SHAPE = (90, 160)


def test_what_is_hot_is_measured_by_the_hottest_cell() -> None:
    heatmap = np.array([[40, 19, 20, 21]], np.uint8)
    assert HOT == 0.5
    assert hot(heatmap).tolist() == [[True, False, True, True]]


def test_nothing_is_hot_in_a_cold_heatmap() -> None:
    assert not hot(np.zeros(SHAPE, np.uint8)).any()


def test_inner_cells_are_a_margin_away_from_the_others() -> None:
    cells = np.zeros((100, 500), np.bool_)
    cells[20:80, 100:400] = True
    margin = round(MARGIN * 500)
    kept = inner(cells)

    assert kept[20 + margin : 80 - margin, 100 + margin : 400 - margin].all()
    assert kept.sum() == (60 - 2 * margin) * (300 - 2 * margin)


def test_of_a_small_heatmap_one_cell_is_the_margin() -> None:
    cells = np.zeros((9, 16), np.bool_)
    cells[2:5, 2:5] = True
    assert np.argwhere(inner(cells)).tolist() == [[3, 3]]


def test_what_reaches_the_border_goes_on_beyond_it() -> None:
    assert inner(np.ones(SHAPE, np.bool_)).all()


@given(
    st.floats(0.0, SIZE[0] - 0.01),
    st.floats(0.0, SIZE[1] - 0.01),
    st.integers(0, SHAPE[0] - 1),
    st.integers(0, SHAPE[1] - 1),
)
def test_the_nearest_is_one_of_the_cells(u: float, v: float, row: int, column: int) -> None:
    cells = np.zeros(SHAPE, np.bool_)
    cells[row, column] = True
    place = nearest(cells, ImagePoint(u, v, clipped=True), SIZE)

    assert place is not None
    assert place.clipped
    assert cells[cell_at(place.u, place.v, SHAPE, SIZE)]


def test_of_two_cells_the_nearer_one() -> None:
    cells = np.zeros(SHAPE, np.bool_)
    cells[10, 20] = cells[10, 40] = True
    place = nearest(cells, ImagePoint(150.0, 42.0, clipped=False), SIZE)
    assert place == ImagePoint(162.0, 42.0, clipped=False)


def test_a_point_on_one_stays() -> None:
    point = ImagePoint(33.3, 44.4, clipped=False)
    assert nearest(np.ones(SHAPE, np.bool_), point, SIZE) is point


@pytest.mark.parametrize("point", [ImagePoint(0.0, 0.0, clipped=False)])
def test_among_no_cells_there_is_none(point: ImagePoint) -> None:
    assert nearest(np.zeros(SHAPE, np.bool_), point, SIZE) is None
