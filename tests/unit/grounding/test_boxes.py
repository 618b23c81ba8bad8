"""Boxes as models give them become boxes to rely on."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from w2c_grounding.boxes import (
    DUPLICATE_OVERLAP,
    MAX_BOXES,
    area,
    distinct,
    intersection_over_union,
    usable,
    window,
)
from w2c_grounding.family import ScoredBox

anything = st.floats(allow_nan=True, allow_infinity=True, width=32)
any_boxes = st.lists(st.builds(ScoredBox, anything, anything, anything, anything, anything))
WIDTH, HEIGHT = 64, 48


@given(any_boxes)
def test_what_is_kept_is_sound_and_the_rest_is_counted(boxes: list[ScoredBox]) -> None:
    kept, dropped = usable(boxes, WIDTH, HEIGHT)
    assert len(kept) + dropped == len(boxes)
    for box in kept:
        assert 0.0 <= box.left < box.right <= WIDTH
        assert 0.0 <= box.top < box.bottom <= HEIGHT
        assert 0.0 <= box.score <= 1.0
        left, top, right, bottom = window(box, WIDTH, HEIGHT)
        assert 0 <= left < right <= WIDTH
        assert 0 <= top < bottom <= HEIGHT
    scores = [box.score for box in kept]
    assert scores == sorted(scores, reverse=True)


@given(any_boxes)
def test_of_what_is_distinct_no_two_overlap_much(boxes: list[ScoredBox]) -> None:
    kept = distinct(usable(boxes, WIDTH, HEIGHT)[0])
    for index, box in enumerate(kept):
        for other in kept[:index]:
            assert intersection_over_union(box, other) <= DUPLICATE_OVERLAP


@pytest.mark.parametrize(
    "box",
    [
        ScoredBox(math.nan, 0, 10, 10, 0.9),
        ScoredBox(0, 0, 10, 10, math.nan),
        ScoredBox(0, 0, math.inf, 10, 0.9),
        ScoredBox(10, 0, 5, 10, 0.9),
        ScoredBox(5, 5, 5, 10, 0.9),
        ScoredBox(70, 5, 90, 10, 0.9),
        ScoredBox(-9, 5, -1, 10, 0.9),
    ],
)
def test_a_box_that_makes_no_sense_is_dropped(box: ScoredBox) -> None:
    assert usable([box], WIDTH, HEIGHT) == ((), 1)


def test_a_box_that_leaves_the_picture_is_clipped() -> None:
    kept, dropped = usable([ScoredBox(-5, -5, 90, 20, 1.5)], WIDTH, HEIGHT)
    assert kept == (ScoredBox(0, 0, WIDTH, 20, 1.0),)
    assert dropped == 0


def test_two_things_stay_two_and_the_same_thing_twice_is_one() -> None:
    best = ScoredBox(10, 10, 30, 30, 0.9)
    again = ScoredBox(11, 10, 31, 30, 0.8)
    touching = ScoredBox(30, 10, 50, 30, 0.7)
    assert distinct([best, again, touching]) == (best, touching)


def test_no_more_boxes_are_compared_than_the_limit() -> None:
    apart = [ScoredBox(2 * i, 0, 2 * i + 1, 1, 0.5) for i in range(10 * MAX_BOXES)]
    assert len(distinct(apart)) == MAX_BOXES


def test_overlap_is_common_over_joint_area() -> None:
    first, second = ScoredBox(0, 0, 4, 4, 1), ScoredBox(2, 0, 6, 4, 1)
    assert area(first) == 16
    assert intersection_over_union(first, second) == pytest.approx(8 / 24)
    assert intersection_over_union(first, ScoredBox(9, 9, 10, 10, 1)) == 0.0


@given(st.integers(0, 62), st.integers(0, 46), st.integers(1, 64), st.integers(1, 48))
def test_the_window_of_a_whole_box_is_the_box(left: int, top: int, wide: int, high: int) -> None:
    right, bottom = min(WIDTH, left + wide), min(HEIGHT, top + high)
    box = ScoredBox(left, top, right, bottom, 1.0)
    assert window(box, WIDTH, HEIGHT) == (left, top, right, bottom)


def test_a_box_between_two_pixel_centres_is_the_pixel_that_holds_it() -> None:
    assert window(ScoredBox(3.6, 2.6, 3.9, 2.9, 1), WIDTH, HEIGHT) == (3, 2, 4, 3)
    assert window(ScoredBox(63.9, 47.9, 64.0, 48.0, 1), WIDTH, HEIGHT) == (63, 47, 64, 48)
    assert np.isclose(area(ScoredBox(3.6, 2.6, 3.9, 2.9, 1)), 0.09)
