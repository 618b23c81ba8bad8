"""How strongly a picture shows a phrase at a place."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from w2c.messages import Box, PhraseEvidence
from w2c_dialogue.advice.heat import Place, heat_at, hits

WIDTH, HEIGHT = 1280, 720
ROWS, COLUMNS = 18, 32


def seen(
    heatmap: np.ndarray | None,
    *,
    phrase: str = "person",
    score: float = 1.0,
    found: bool = True,
    box: tuple[float, float, float, float] | None = None,
) -> PhraseEvidence:
    left, top, right, bottom = box or (0, 0, 1, 1)
    boxes = [Box(left=left, top=top, right=right, bottom=bottom, score=score)] if box else []
    return PhraseEvidence(
        phrase=phrase, found=found, score=score, point=None, boxes=boxes, heatmap=heatmap
    )


def place(u: float, v: float, radius: float = 0.0) -> Place:
    return Place(u, v, radius, WIDTH, HEIGHT)


pixels = st.tuples(st.floats(0, WIDTH), st.floats(0, HEIGHT))
maps = st.integers(0, 2**32 - 1).map(
    lambda seed: np.random.default_rng(seed).integers(0, 256, (ROWS, COLUMNS)).astype(np.uint8)
)


@given(heatmap=maps, at=pixels)
def test_without_a_radius_it_is_the_cell_that_holds_the_pixel(
    heatmap: np.ndarray,
    at: tuple[float, float],
) -> None:
    """The heatmap is a thumbnail of the picture; the last pixel's border belongs to the picture."""
    row = min(int(at[1] / (HEIGHT / ROWS)), ROWS - 1)
    column = min(int(at[0] / (WIDTH / COLUMNS)), COLUMNS - 1)
    assert heat_at(seen(heatmap), place(*at)) == heatmap[row, column] / 255.0


@given(heatmap=maps, at=pixels, radii=st.tuples(st.floats(0, 300), st.floats(0, 300)))
def test_a_larger_place_is_never_cooler(
    heatmap: np.ndarray,
    at: tuple[float, float],
    radii: tuple[float, float],
) -> None:
    small, large = sorted(radii)
    cooler = heat_at(seen(heatmap), place(*at, small))
    warmer = heat_at(seen(heatmap), place(*at, large))
    assert cooler <= warmer <= heatmap.max() / 255.0


@given(at=pixels, radius=st.floats(0, 200), cell=st.tuples(st.integers(0, 17), st.integers(0, 31)))
def test_one_hot_cell_counts_where_its_middle_is_inside(
    at: tuple[float, float], radius: float, cell: tuple[int, int]
) -> None:
    heatmap = np.zeros((ROWS, COLUMNS), np.uint8)
    heatmap[cell] = 200
    middle = np.array([(cell[1] + 0.5) * WIDTH / COLUMNS, (cell[0] + 0.5) * HEIGHT / ROWS])
    away = float(np.linalg.norm(middle - at))
    heat = heat_at(seen(heatmap), place(*at, radius))
    if away < radius - 1e-6:
        assert heat == pytest.approx(200 / 255)
    elif away > radius + 30.0:  # beyond half of a cell's diagonal
        assert heat == 0.0


@pytest.mark.parametrize(("radius", "expected"), [(9.0, 0.0), (11.0, 0.7)])
def test_a_model_without_heatmaps_is_taken_at_its_boxes(radius: float, expected: float) -> None:
    evidence = seen(None, score=0.7, box=(400, 300, 600, 420))
    assert heat_at(evidence, place(500, 360)) == 0.7
    assert heat_at(evidence, place(390, 360, radius)) == expected


def test_only_what_is_found_counts_and_the_strongest_comes_first() -> None:
    heatmap = np.full((ROWS, COLUMNS), 100, np.uint8)
    evidence = [
        seen(heatmap, phrase="dog", score=0.9),
        seen(2 * heatmap, phrase="person", score=0.8),
        seen(2 * heatmap, phrase="flame", score=0.8, found=False),
    ]
    found = hits(evidence, place(500, 360), share=0.3)
    assert [hit.phrase for hit in found] == ["person", "dog"]
    assert found[1].limit == pytest.approx(0.27)
    assert found[1].heat == pytest.approx(100 / 255)


def test_the_limit_is_a_share_of_the_highest_heat_in_the_picture() -> None:
    heatmap = np.full((ROWS, COLUMNS), 76, np.uint8)  # 0.298
    assert not hits([seen(heatmap, score=1.0)], place(10, 10), share=0.3)
    assert hits([seen(heatmap, score=0.9)], place(10, 10), share=0.3)
