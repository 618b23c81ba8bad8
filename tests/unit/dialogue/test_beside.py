"""Beside a thing is at its foot; other places keep their height."""

import pytest

from w2c.messages import Box
from w2c_dialogue.beside import (
    FOOT,
    INSIDE,
    LEAST_LEFT,
    NEEDED_CM,
    USUAL,
    Described,
    at_its_foot,
    near_enough,
)
from w2c_dialogue.expressions import ImagePoint
from w2c_dialogue.prompts.base import SceneObject

MUG = SceneObject("mug", Box(left=400.0, top=200.0, right=500.0, bottom=300.0, score=0.9))
BOOK = SceneObject("book", Box(left=700.0, top=200.0, right=900.0, bottom=300.0, score=0.9))


@pytest.mark.parametrize("u", [370.0, 530.0, 900.0])
def test_level_with_its_middle_becomes_level_with_its_foot(u: float) -> None:
    point = at_its_foot(ImagePoint(u, 250.0, clipped=False), [MUG])
    assert point == ImagePoint(u, 200.0 + FOOT * 100.0, clipped=False)
    assert 250.0 < point.v < 300.0


@pytest.mark.parametrize(
    ("point", "objects"),
    [
        pytest.param(ImagePoint(450.0, 250.0, clipped=False), [MUG], id="on it"),
        pytest.param(ImagePoint(450.0, 170.0, clipped=False), [MUG], id="behind it"),
        pytest.param(ImagePoint(370.0, 200.0, clipped=False), [MUG], id="at its upper edge"),
        pytest.param(ImagePoint(370.0, 260.0, clipped=False), [MUG], id="a height of its own"),
        pytest.param(ImagePoint(600.0, 250.0, clipped=False), [MUG, BOOK], id="between two"),
        pytest.param(ImagePoint(1279.0, 250.0, clipped=True), [MUG], id="outside the picture"),
        pytest.param(ImagePoint(370.0, 250.0, clipped=False), [], id="of nothing"),
    ],
)
def test_every_other_place_stays(point: ImagePoint, objects: list[SceneObject]) -> None:
    assert at_its_foot(point, objects) is point


PX_PER_CM = 4.0
LARGE = SceneObject("crate", Box(left=400.0, top=200.0, right=800.0, bottom=500.0, score=0.9))
LEFT, RIGHT = 400.0 - USUAL * 400.0, 800.0 + USUAL * 400.0
BEHIND, BEFORE = 200.0 - USUAL * 300.0, 500.0 + USUAL * 300.0
ACROSS, ALONG = NEEDED_CM[0] * PX_PER_CM, NEEDED_CM[1] * PX_PER_CM


@pytest.mark.parametrize(
    ("place", "near"),
    [
        pytest.param((LEFT, 350.0), (400.0 - ACROSS, 350.0), id="left"),
        pytest.param((RIGHT, 350.0), (800.0 + ACROSS, 350.0), id="right"),
        pytest.param((600.0, BEHIND), (600.0, 200.0 - ALONG), id="behind"),
        pytest.param((600.0, BEFORE), (600.0, 500.0 + ALONG), id="before"),
        pytest.param((LEFT, BEFORE), (400.0 - ACROSS, 500.0 + ALONG), id="before and left"),
        pytest.param((LEFT, 700.0), (400.0 - ACROSS, 700.0), id="left, and another length"),
    ],
)
def test_where_no_length_is_said_a_place_is_as_near_as_a_hand_needs(
    place: tuple[float, float], near: tuple[float, float]
) -> None:
    assert near_enough(Described(*place), [LARGE], PX_PER_CM) == pytest.approx(near)


@pytest.mark.parametrize(
    ("place", "objects", "pixels_per_cm"),
    [
        pytest.param((LEFT - 8.0, 350.0), [LARGE], PX_PER_CM, id="a length that was said"),
        pytest.param((LEFT, 350.0), [LARGE], 40.0, id="a small thing"),
        pytest.param((600.0, 350.0), [LARGE], PX_PER_CM, id="on it"),
        pytest.param((LEFT, 350.0), [LARGE, MUG], PX_PER_CM, id="of two things"),
        pytest.param((LEFT, 350.0), [], PX_PER_CM, id="of nothing"),
    ],
)
def test_every_other_distance_stays(
    place: tuple[float, float], objects: list[SceneObject], pixels_per_cm: float
) -> None:
    assert near_enough(Described(*place), objects, pixels_per_cm) == place


STANDS = INSIDE * 300.0
"""Inside of the outline of the crate [px]"""


@pytest.mark.parametrize(
    ("place", "u"),
    [
        pytest.param(Described(300.0, 350.0, -100.0), 300.0 + STANDS, id="25 cm left"),
        pytest.param(Described(900.0, 350.0, 100.0), 900.0 - STANDS, id="25 cm right"),
        pytest.param(Described(380.0, 350.0, -20.0), 400.0 - LEAST_LEFT * 20.0, id="5 cm left"),
        pytest.param(Described(300.0, 500.0, -100.0), 300.0, id="at a height of its own"),
        pytest.param(Described(500.0, 350.0, -100.0), 500.0, id="from its middle"),
        pytest.param(Described(500.0, 350.0, 100.0), 500.0, id="from its left edge, on it"),
    ],
)
def test_a_distance_that_is_said_is_one_from_where_a_thing_stands(
    place: Described, u: float
) -> None:
    assert near_enough(place, [LARGE], PX_PER_CM) == pytest.approx((u, place.v))
    assert near_enough(place, [LARGE, MUG], PX_PER_CM) == (place.u, place.v)
