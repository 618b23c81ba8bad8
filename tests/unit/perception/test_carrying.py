"""What is told of a surface that is to carry a hand."""

import numpy as np
import pytest

from w2c.messages import Array
from w2c_perception.carrying import load_on, verdicts
from w2c_perception.lift import Surface


def surface(normal: Array, extent: float = 0.2) -> Surface:
    return Surface(
        point=np.zeros(3),
        normal=normal,
        error_bound=0.002,
        flatness=0.001,
        slope=float(np.arccos(normal[2])),
        extent=extent,
        edge_distance=extent,
        warning="",
    )


@pytest.mark.parametrize(
    ("degrees", "fits"), [(0.0, True), (25.0, True), (40.0, False), (90.0, True)]
)
def test_a_table_takes_weight_and_a_wall_a_push_but_a_slide_neither(
    degrees: float, fits: bool
) -> None:
    angle = np.radians(degrees)
    slope = verdicts(surface(np.array([-np.sin(angle), 0.0, np.cos(angle)])), 0.002, 0.03)[-1]
    assert (slope.check, slope.fit) == ("slope", fits)


def test_each_verdict_has_value_and_limit() -> None:
    found = {v.check: v for v in verdicts(surface(np.array([0.0, 0.0, 1.0]), 0.02), 0.03, 0.03)}
    assert set(found) == {"known", "flat", "large", "edge", "slope"}
    assert not found["known"].fit  # the bound with the camera's pose, not the surface's own
    assert (found["large"].value, found["large"].limit) == (0.02, 0.03)
    assert "too small" in found["large"].reason


def test_the_load_on_a_ceiling_is_weight_that_it_cannot_take() -> None:
    ceiling = np.array([0.0, 0.0, -1.0])
    np.testing.assert_array_equal(load_on(ceiling), [0.0, 0.0, -1.0])
    assert not verdicts(surface(ceiling), 0.002, 0.03)[-1].fit
