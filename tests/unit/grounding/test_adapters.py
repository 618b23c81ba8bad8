"""Boxes, masks, polygons and points fill the slot of a heatmap, and the way back finds them."""

import tracemalloc
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from w2c_grounding.adapters import (
    RIM,
    boxes_from_masks,
    heatmap_from_boxes,
    heatmap_from_masks,
    heatmap_from_points,
    heatmap_from_polygons,
)
from w2c_grounding.evidence import PointRule, find, peak_point, regions_of
from w2c_grounding.family import Heatmap, ScoredBox

WIDTH, HEIGHT = 96, 64
RULES: tuple[PointRule, ...] = ("interior", "peak")
anything = st.floats(allow_nan=True, allow_infinity=True, width=32)
scores = st.floats(0.05, 1.0)


@st.composite
def whole_boxes(draw: st.DrawFn) -> ScoredBox:
    """Return a box with corners on pixel borders, inside the picture."""
    left, top = draw(st.integers(0, WIDTH - 1)), draw(st.integers(0, HEIGHT - 1))
    right, bottom = draw(st.integers(left + 1, WIDTH)), draw(st.integers(top + 1, HEIGHT))
    return ScoredBox(left, top, right, bottom, draw(scores))


@settings(max_examples=50)
@given(whole_boxes())
def test_the_region_of_a_box_is_the_box_and_its_peak_the_score(box: ScoredBox) -> None:
    heat = heatmap_from_boxes([box], WIDTH, HEIGHT)
    (region,) = regions_of(heat, 0.01)
    assert (region.left, region.top, region.right, region.bottom) == box[:4]
    assert region.mask.all()
    assert region.score == pytest.approx(box.score)
    assert heat[heat > 0].min() >= RIM * box.score - 1e-6


@settings(max_examples=50)
@given(whole_boxes())
def test_the_peak_of_a_box_is_its_centre(box: ScoredBox) -> None:
    u, v = peak_point(heatmap_from_boxes([box], WIDTH, HEIGHT))
    centre = ((box.left + box.right) / 2, (box.top + box.bottom) / 2)
    assert (u, v) == pytest.approx(centre, abs=0.5)


@settings(max_examples=50)
@given(whole_boxes(), whole_boxes())
def test_where_two_boxes_overlap_the_more_certain_one_counts(
    first: ScoredBox, second: ScoredBox
) -> None:
    both = heatmap_from_boxes([first, second], WIDTH, HEIGHT)
    alone = [heatmap_from_boxes([box], WIDTH, HEIGHT) for box in (first, second)]
    np.testing.assert_array_equal(both, np.maximum(*alone))


@settings(max_examples=50)
@given(whole_boxes())
def test_a_mask_gives_its_region_and_its_box(box: ScoredBox) -> None:
    mask = np.zeros((HEIGHT, WIDTH), dtype=bool)
    mask[int(box.top) : int(box.bottom), int(box.left) : int(box.right)] = True
    assert boxes_from_masks([mask], [box.score], WIDTH, HEIGHT) == (box,)
    expected = np.where(mask, np.float32(box.score), np.float32(0))
    for kind in (mask, mask.astype(np.uint8) * 255, mask.astype(np.float32)):
        heat = heatmap_from_masks([kind], [box.score], WIDTH, HEIGHT)
        np.testing.assert_allclose(heat, expected, atol=1e-6)


def test_a_coarse_mask_covers_the_whole_picture() -> None:
    mask = np.zeros((HEIGHT // 8, WIDTH // 8), dtype=bool)
    mask[2:4, 3:6] = True
    assert boxes_from_masks([mask], [0.5], WIDTH, HEIGHT) == (ScoredBox(24, 16, 48, 32, 0.5),)
    (region,) = regions_of(heatmap_from_masks([mask], [0.5], WIDTH, HEIGHT), 0.1)
    assert (region.left, region.top, region.right, region.bottom) == (24, 16, 48, 32)


def test_a_soft_mask_keeps_its_probabilities() -> None:
    soft = np.array([[0.0, 1.0], [np.nan, 7.0]], dtype=np.float16)
    heat = heatmap_from_masks([soft], [0.5], 2, 2)
    np.testing.assert_allclose(heat, [[0.0, 0.5], [0.0, 0.5]])


@settings(max_examples=50)
@given(whole_boxes())
def test_a_polygon_gives_its_inside_to_a_pixel(box: ScoredBox) -> None:
    corners = [
        (box.left, box.top),
        (box.right, box.top),
        (box.right, box.bottom),
        (box.left, box.bottom),
    ]
    (region,) = regions_of(heatmap_from_polygons([corners], [box.score], WIDTH, HEIGHT), 0.01)
    found = (region.left, region.top, region.right, region.bottom)
    assert found == pytest.approx(box[:4], abs=1.0)
    assert region.mask.all()


def test_a_polygon_that_is_no_rectangle_is_filled_exactly_inside() -> None:
    heat = heatmap_from_polygons([[(10, 10), (50, 10), (10, 50)]], [0.7], WIDTH, HEIGHT)
    rows, columns = np.mgrid[0:HEIGHT, 0:WIDTH] + 0.5
    depth = np.minimum.reduce([columns - 10, rows - 10, (60 - columns - rows) / np.sqrt(2)])
    assert np.allclose(heat[depth > 0.75], 0.7)
    assert (heat[depth < -0.75] == 0).all()


@settings(max_examples=50)
@given(st.floats(0, WIDTH - 0.01), st.floats(0, HEIGHT - 0.01), scores, st.floats(0.1, 40))
def test_the_peak_of_a_point_is_the_pixel_that_holds_it(
    u: float, v: float, score: float, radius: float
) -> None:
    heat = heatmap_from_points([(u, v)], [score], WIDTH, HEIGHT, radius)
    assert peak_point(heat) == (int(u) + 0.5, int(v) + 0.5)
    assert float(heat.max()) == pytest.approx(score)


def test_the_region_of_a_point_is_a_disc_of_the_radius() -> None:
    (region,) = regions_of(heatmap_from_points([(40.5, 30.5)], [0.8], WIDTH, HEIGHT, 10.0), 0.1)
    assert (region.left, region.top, region.right, region.bottom) == (30, 20, 51, 41)
    assert region.mask.sum() == pytest.approx(np.pi * 10.0**2, rel=0.05)


Maker = Callable[[list[float]], Heatmap]


@pytest.mark.parametrize(
    "make",
    [
        lambda n: heatmap_from_boxes([ScoredBox(*n[:5])], WIDTH, HEIGHT),
        lambda n: heatmap_from_points([(n[0], n[1])], [n[2]], WIDTH, HEIGHT, 5.0),
        lambda n: heatmap_from_polygons(
            [[(n[0], n[1]), (n[2], n[3]), (n[4], n[5])]], [n[6]], WIDTH, HEIGHT
        ),
        lambda n: heatmap_from_masks(
            [np.array(n[:6], dtype=np.float32).reshape(2, 3)], [n[6]], WIDTH, HEIGHT
        ),
    ],
)
@settings(max_examples=50)
@given(st.lists(anything, min_size=7, max_size=7))
def test_whatever_a_model_answers_heat_is_a_probability(make: Maker, numbers: list[float]) -> None:
    heat = make(numbers)
    assert heat.shape == (HEIGHT, WIDTH)
    assert heat.dtype == np.float32
    assert np.isfinite(heat).all()
    assert 0.0 <= heat.min() <= heat.max() <= 1.0


def test_nothing_answered_is_a_cold_picture() -> None:
    for heat in (
        heatmap_from_boxes([], WIDTH, HEIGHT),
        heatmap_from_masks([], [], WIDTH, HEIGHT),
        heatmap_from_polygons([[(1, 1), (2, 2)]], [0.9], WIDTH, HEIGHT),
        heatmap_from_points([(-1, 5)], [0.9], WIDTH, HEIGHT, 5.0),
    ):
        assert not heat.any()
    assert boxes_from_masks([np.zeros((4, 4), dtype=bool)], [0.9], WIDTH, HEIGHT) == ()


def test_a_detectors_evidence_ends_as_its_boxes_with_the_best_point_in_the_middle() -> None:
    boxes = (ScoredBox(10, 10, 30, 30, 0.6), ScoredBox(50, 20, 90, 40, 0.9))
    heat = heatmap_from_boxes(boxes, WIDTH, HEIGHT)
    for rule in RULES:
        finding = find(heat, 0.5, rule, boxes)
        assert finding.point == pytest.approx((70, 30), abs=1.0)
        assert [region.score for region in finding.regions] == [0.9, 0.6]


def test_many_things_take_no_more_memory_than_two_pictures() -> None:
    width, height, count = 1600, 1200, 20
    one = width * height * 4
    mask = np.ones((height, width), dtype=bool)
    box = ScoredBox(0, 0, width, height, 0.5)
    corners = [(0, 0), (width, 0), (width, height)]
    makers: list[Callable[[], Heatmap]] = [
        lambda: heatmap_from_boxes([box] * count, width, height),
        lambda: heatmap_from_masks([mask] * count, [0.5] * count, width, height),
        lambda: heatmap_from_polygons([corners] * count, [0.5] * count, width, height),
        lambda: heatmap_from_points([(800, 600)] * count, [0.5] * count, width, height, 400.0),
    ]
    for make in makers:
        tracemalloc.start()
        make()
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert peak < 2.2 * one
