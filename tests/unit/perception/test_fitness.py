"""Verdicts on a surface: each limit from both sides, and words that an operator understands."""

from dataclasses import replace
from typing import Any

import msgspec
import numpy as np
import pytest

from w2c.errors import ConfigError, GeometryError
from w2c_perception.fitness import Demands, Shape, is_fit, judge

UP = np.array([0.0, 0.0, 1.0])
TABLE = Shape(UP, error_bound=0.002, flatness=0.001, extent=0.2, edge_distance=0.25)


def table(**changes: Any) -> Shape:
    """Return a table that differs in something."""
    return replace(TABLE, **changes)


def tilted(degrees: float) -> np.ndarray:
    return np.array([np.sin(np.radians(degrees)), 0.0, np.cos(np.radians(degrees))])


def test_a_table_is_fit_and_every_check_says_why() -> None:
    verdicts = judge(TABLE, Demands())

    assert is_fit(verdicts)
    assert [verdict.check for verdict in verdicts] == ["known", "flat", "large", "edge", "slope"]
    assert all(verdict.reason for verdict in verdicts)


@pytest.mark.parametrize(
    ("check", "field", "fit", "unfit", "words"),
    [
        ("known", "error_bound", 0.0199, 0.0201, "only to 20.1 mm, limit 20.0 mm"),
        ("flat", "flatness", 0.0039, 0.0041, "not flat: uneven by 4.1 mm, limit 4.0 mm"),
        ("large", "extent", 0.031, 0.029, "free for 2.9 cm around, the hand needs 3.0 cm"),
        ("edge", "edge_distance", 0.051, 0.049, "it ends 4.9 cm away, limit 5.0 cm"),
        ("slope", "normal", tilted(30.5), tilted(31.5), "friction 0.6 holds up to 31"),
    ],
)
def test_each_limit_decides_one_check(
    check: str, field: str, fit: object, unfit: object, words: str
) -> None:
    passed = judge(table(**{field: fit}), Demands())
    failed = judge(table(**{field: unfit}), Demands())

    assert is_fit(passed)
    assert [verdict.check for verdict in failed if not verdict.fit] == [check]
    assert words in next(verdict.reason for verdict in failed if not verdict.fit)


def test_a_wall_carries_no_weight_but_a_push() -> None:
    wall = table(normal=np.array([-1.0, 0.0, 0.0]))

    assert not is_fit(judge(wall, Demands()))
    assert is_fit(judge(wall, Demands(), load=np.array([1.0, 0.0, 0.0])))


def test_the_underside_of_a_table_carries_nothing() -> None:
    verdicts = judge(table(normal=-UP), Demands())

    assert "faces away from the load" in verdicts[-1].reason
    assert not is_fit(verdicts)


def test_more_friction_holds_steeper_surfaces() -> None:
    slope = table(normal=tilted(40.0))

    assert not is_fit(judge(slope, Demands(friction=0.6)))
    assert is_fit(judge(slope, Demands(friction=0.9)))


@pytest.mark.parametrize("field", ["radius", "roughness", "margin", "friction", "error"])
@pytest.mark.parametrize("value", [-0.1, float("nan")])
def test_demands_that_are_none_are_refused(field: str, value: float) -> None:
    with pytest.raises(ConfigError, match="finite"):
        Demands(**{field: value})


def test_a_load_without_direction_is_refused() -> None:
    with pytest.raises(GeometryError, match="no direction"):
        judge(TABLE, Demands(), load=np.zeros(3))


def test_verdicts_are_plain_data() -> None:
    verdict = judge(TABLE, Demands())[0]

    assert msgspec.to_builtins(verdict)["limit"] == pytest.approx(0.02)
