"""Heatmaps become answers."""

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from w2c.errors import ModelError
from w2c_grounding.evidence import (
    REGION_FRACTION,
    find,
    heatmap_from_logits,
    interior_point,
    peak_point,
    regions_of,
    thumbnail,
)
from w2c_grounding.family import ScoredBox

Heat = npt.NDArray[np.float32]

heatmaps = arrays(
    np.float32,
    st.tuples(st.integers(2, 40), st.integers(2, 40)),
    elements=st.floats(0.0, 1.0, width=32),
)


def disc(u: float, v: float, radius: float, height: int = 60, width: int = 100) -> Heat:
    rows, columns = np.mgrid[0:height, 0:width]
    inside = np.hypot(columns + 0.5 - u, rows + 0.5 - v) < radius
    return np.where(inside, 0.9, 0.05).astype(np.float32)


@given(heatmaps, st.floats(0.05, 0.95))
def test_the_point_lies_in_the_best_region_whatever_the_heatmap(
    heat: Heat, threshold: float
) -> None:
    finding = find(heat, threshold)
    if not finding.found:
        assert finding.score < threshold
        return
    assert finding.point is not None
    u, v = finding.point
    best = finding.regions[0]
    assert best.left <= u < best.right
    assert best.top <= v < best.bottom
    assert best.mask[int(v) - best.top, int(u) - best.left]


@given(heatmaps, st.sampled_from((REGION_FRACTION, 0.3, 0.9)))
def test_regions_cover_exactly_the_hot_pixels_and_boxes_are_tight(heat: Heat, edge: float) -> None:
    covered = np.zeros(heat.shape, dtype=bool)
    # A threshold of nothing keeps every region.
    for region in regions_of(heat, 0.0, edge):
        window = covered[region.top : region.bottom, region.left : region.right]
        assert not (window & region.mask).any(), "regions overlap"
        window |= region.mask
        edges = region.mask[:, 0], region.mask[:, -1], region.mask[0], region.mask[-1]
        assert all(edge.any() for edge in edges), "the box is larger than the region"
    assert (covered == (heat >= edge * heat.max())).all()


@given(heatmaps)
def test_the_best_region_comes_first_and_holds_the_peak(heat: Heat) -> None:
    scores = [region.score for region in regions_of(heat, 0.0)]
    assert scores == sorted(scores, reverse=True)
    assert scores[0] == pytest.approx(float(heat.max()))


@given(heatmaps)
def test_the_peak_point_is_the_centre_of_the_hottest_pixel(heat: Heat) -> None:
    u, v = peak_point(heat)
    assert heat[int(v), int(u)] == heat.max()
    assert (u % 1.0, v % 1.0) == (0.5, 0.5)


def test_below_the_threshold_nothing_is_found_and_the_score_says_how_far() -> None:
    finding = find(np.full((10, 10), 0.2, dtype=np.float32), 0.5)
    assert not finding.found
    assert finding.regions == ()
    assert finding.point is None
    assert finding.score == pytest.approx(0.2)


def test_two_things_give_two_boxes_and_a_weak_one_is_left_out() -> None:
    heat = np.maximum(disc(20, 30, 8), 0.9 * disc(70, 30, 8))
    heat = np.maximum(heat, 0.55 * disc(50, 10, 4)).astype(np.float32)
    regions = find(heat, 0.6).regions
    assert [(r.left, r.top, r.right, r.bottom) for r in regions] == [
        (12, 22, 28, 38),
        (62, 22, 78, 38),
    ]


def test_the_interior_point_keeps_away_from_a_hot_rim() -> None:
    heat = disc(50, 30, 20)
    heat[30, 31] = 1.0  # the hottest pixel, at the rim
    point = find(heat, 0.5, "interior").point
    assert point is not None
    assert np.hypot(point[0] - 50, point[1] - 30) < 3.0
    assert find(heat, 0.5, "peak").point == (31.5, 30.5)


def test_a_thing_reaches_as_far_as_its_edge_and_its_point_keeps_to_what_is_hot() -> None:
    heat = np.zeros((40, 100), dtype=np.float32)
    heat[10:30, 10:30] = 0.9
    heat[10:30, 30:90] = 0.4  # less than half of the peak
    narrow, wide = find(heat, 0.5), find(heat, 0.5, edge=0.3)
    assert (narrow.regions[0].left, narrow.regions[0].right) == (10, 30)
    assert (wide.regions[0].left, wide.regions[0].right) == (10, 90)
    assert narrow.point == pytest.approx((20, 20), abs=1.0)
    assert wide.point is not None
    assert 20 < wide.point[0] < 30


def test_the_point_is_near_the_middle_of_a_thing_that_is_hotter_at_one_end() -> None:
    heat = np.zeros((60, 140), dtype=np.float32)
    heat[20:40, 20:100] = np.linspace(0.95, 0.6, 80)
    u, v = interior_point(heat, regions_of(heat, 0.5)[0])
    assert (u, v) == pytest.approx((57, 30), abs=4.0)


def test_in_a_long_thin_region_the_point_stays_where_it_is_hot() -> None:
    heat = np.zeros((4, 4000), dtype=np.float32)
    heat[1, :] = 0.3
    heat[1, :5] = 0.9
    u, v = interior_point(heat, regions_of(heat, 0.5, 0.2)[0])
    assert u < 5
    assert v == 1.5


def test_the_border_of_the_picture_counts_as_an_edge() -> None:
    heat = np.zeros((40, 100), dtype=np.float32)
    heat[:, :40] = 0.8
    u, v = interior_point(heat, regions_of(heat, 0.5)[0])
    assert (u, v) == pytest.approx((20, 20), abs=1.0)


def test_the_point_prefers_the_hotter_part_of_a_region() -> None:
    heat = np.full((21, 61), 0.55, dtype=np.float32)
    heat[:, 40:] = 0.95
    u, _ = interior_point(heat, regions_of(heat, 0.5)[0])
    assert u > 40


def test_logits_become_probabilities_over_the_whole_picture() -> None:
    logits = np.array([[-100.0, 100.0], [0.0, 0.0]], dtype=np.float32)
    heat = heatmap_from_logits(logits, width=8, height=4)
    assert heat.shape == (4, 8)
    assert heat.dtype == np.float32
    assert heat[0, 0] == pytest.approx(0.0, abs=1e-6)
    assert heat[0, 7] == pytest.approx(1.0, abs=1e-6)
    assert heat[3] == pytest.approx(0.5)


def test_the_thumbnail_keeps_the_shape_of_the_picture_and_bounds_its_size() -> None:
    small = thumbnail(np.ones((720, 1280), dtype=np.float32))
    assert small.shape == (180, 320)
    assert small.dtype == np.uint8
    assert (small == 255).all()
    assert thumbnail(np.zeros((3, 5), dtype=np.float32)).shape == (3, 5)


def test_a_models_own_boxes_say_what_was_found() -> None:
    heat = disc(20, 30, 8)
    boxes = [
        ScoredBox(60, 20, 80, 40, 0.5),
        ScoredBox(12, 22, 28, 38, 0.8),
        ScoredBox(13, 22, 29, 38, 0.7),
        ScoredBox(0, 0, 5, 5, 0.2),
    ]
    finding = find(heat, 0.4, boxes=boxes)
    assert [(r.left, r.score) for r in finding.regions] == [(12, 0.8), (60, 0.5)]
    assert finding.score == 0.8
    assert finding.point == pytest.approx((20, 30), abs=1.5)
    assert finding.regions[0].mask.sum() == (heat == np.float32(0.9)).sum()


def test_a_box_that_the_heatmap_does_not_show_is_touched_in_its_middle() -> None:
    cold = np.zeros((60, 100), dtype=np.float32)
    assert find(cold, 0.4, boxes=[ScoredBox(60, 20, 81, 41, 0.5)]).point == (70.5, 30.5)


def test_boxes_decide_even_where_the_heatmap_is_hot() -> None:
    hot = disc(50, 30, 20)
    for boxes in ((), (ScoredBox(40, 20, 60, 40, 0.1),)):
        finding = find(hot, 0.5, boxes=boxes)
        assert not finding.found
        assert finding.point is None
        assert finding.score == (boxes[0].score if boxes else 0.0)


def test_boxes_that_make_no_sense_are_counted_not_believed() -> None:
    boxes = [ScoredBox(float("nan"), 0, 10, 10, 0.99), ScoredBox(9, 9, 3, 3, 0.98)]
    finding = find(disc(50, 30, 20), 0.5, boxes=boxes)
    assert (finding.found, finding.score, finding.dropped_boxes) == (False, 0.0, 2)


def test_the_peak_rule_stays_in_the_best_box() -> None:
    heat = np.maximum(disc(20, 30, 5), 0.0)
    heat[30, 80] = 1.0
    boxes = [ScoredBox(10, 20, 30, 40, 0.8), ScoredBox(75, 25, 85, 35, 0.6)]
    point = find(heat, 0.5, "peak", boxes).point
    assert point is not None
    assert np.hypot(point[0] - 20, point[1] - 30) < 5


def test_a_heatmap_that_is_no_number_is_an_error_not_an_answer() -> None:
    heat = disc(20, 30, 5)
    heat[0, 0] = np.nan
    with pytest.raises(ModelError, match="--dtype float32"):
        find(heat, 0.5)


def test_boxes_without_any_score_that_is_a_number_are_an_error_not_an_empty_picture() -> None:
    boxes = [ScoredBox(10, 20, 30, 40, float("nan")), ScoredBox(1, 2, 3, 4, float("nan"))]
    with pytest.raises(ModelError, match=r"none of the 2 boxes .*--dtype float32"):
        find(disc(20, 30, 5), 0.5, boxes=boxes)
