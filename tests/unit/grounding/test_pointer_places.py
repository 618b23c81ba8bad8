"""Numbers of answers as pixels of the picture."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from w2c_grounding.evidence import find
from w2c_grounding.pointer.options import Units
from w2c_grounding.pointer.places import Frame, Place, box_within, evidence_of, point_within

FRAME = Frame(320, 180, 160, 90)
"""The model got half the size"""

ANY = st.floats(allow_nan=True, allow_infinity=True)


def point_of(place: Place, units: Units = "auto") -> tuple[float, float] | None:
    evidence, _ = evidence_of([place], units, FRAME, 0.02)
    return find(evidence.heatmap, 0.5, "interior", evidence.boxes).point


@pytest.mark.parametrize(
    ("numbers", "units", "scale"),
    [
        ((0.25, 0.5), "auto", None),
        ((0.25, 0.5), "unit", None),
        ((250.0, 500.0), "auto", None),
        ((250.0, 500.0), "thousand", None),
        ((25.0, 50.0), "hundred", None),
        ((40.0, 45.0), "pixels", None),
        ((25.0, 50.0), "pixels", 100.0),
    ],
)
def test_every_unit_names_the_same_pixel(
    numbers: tuple[float, float], units: Units, scale: float | None
) -> None:
    assert point_of(Place(numbers, scale), units) == pytest.approx((80, 90), abs=1.0)


def test_units_are_of_the_whole_answer() -> None:
    """(1, 1) of 1000 beside (900, 900) is a corner, not the far edge."""
    evidence, dropped = evidence_of([Place((1.0, 1.0)), Place((900.0, 900.0))], "auto", FRAME, 0.02)
    assert dropped == 0
    assert evidence.heatmap[0, 0] > 0.5
    assert evidence.heatmap[162, 288] > 0.5


def test_a_box_is_the_thing_and_its_middle_the_point() -> None:
    place = Place((250.0, 500.0, 500.0, 750.0))
    evidence, _ = evidence_of([place], "auto", FRAME, 0.02)
    assert evidence.boxes is not None
    (box,) = evidence.boxes
    assert box[:4] == pytest.approx((80, 90, 160, 135))
    assert point_of(place) == pytest.approx((120, 112.5), abs=1.5)


def test_two_points_are_two_things() -> None:
    evidence, _ = evidence_of([Place((0.2, 0.2)), Place((0.8, 0.8))], "auto", FRAME, 0.02)
    assert len(find(evidence.heatmap, 0.5).regions) == 2


def test_no_place_is_not_found() -> None:
    evidence, dropped = evidence_of([], "auto", FRAME, 0.02)
    assert dropped == 0
    assert not find(evidence.heatmap, 0.5, "interior", evidence.boxes).found


def test_just_outside_is_meant_at_the_edge_and_far_outside_is_dropped() -> None:
    assert point_within((322.0, -2.0), FRAME) == (319.5, 0.0)
    assert point_within((400.0, 90.0), FRAME) is None
    evidence, dropped = evidence_of(
        [Place((1500.0, 500.0)), Place((500.0, 500.0))], "auto", FRAME, 0.02
    )
    assert dropped == 1
    assert find(evidence.heatmap, 0.5).found


@given(st.lists(st.one_of(st.tuples(ANY, ANY), st.tuples(ANY, ANY, ANY, ANY)), max_size=6))
@settings(max_examples=40)
def test_whatever_the_numbers_places_are_inside_or_counted(
    numbers: list[tuple[float, ...]],
) -> None:
    for units in ("auto", "unit", "hundred", "thousand", "pixels"):
        evidence, dropped = evidence_of([Place(n) for n in numbers], units, FRAME, 0.02)
        assert 0 <= dropped <= len(numbers)
        assert np.isfinite(evidence.heatmap).all()
        assert evidence.heatmap.shape == (180, 320)
        if dropped == len(numbers):
            assert not evidence.heatmap.any()


@given(st.tuples(ANY, ANY, ANY, ANY))
@settings(max_examples=40)
def test_a_box_is_inside_the_picture_or_none(numbers: tuple[float, ...]) -> None:
    box = box_within(numbers, FRAME)
    if box is not None:
        assert 0 <= box.left < box.right <= 320
        assert 0 <= box.top < box.bottom <= 180
        assert all(math.isfinite(value) for value in numbers)
