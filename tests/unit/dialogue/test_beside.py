"""Beside a thing is at its foot; other places keep their height."""

import pytest

from w2c.messages import Box
from w2c_dialogue.beside import FOOT, at_its_foot
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
