"""Differences of messages: none where they are equal, else where and by how much."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from w2c.difference import Difference, differences
from w2c.messages import JointCommand

VALUES: Any = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner, max_size=3)
    ),
    max_leaves=8,
)


def found(first: object, second: object, *without: str) -> list[Difference]:
    return list(differences(first, second, without))


@given(VALUES)
def test_what_is_equal_has_no_difference(value: object) -> None:
    copy = {"x": value}
    assert found({"x": value}, copy) == []


@given(VALUES, VALUES)
def test_there_is_a_difference_exactly_where_values_differ(first: object, second: object) -> None:
    there = bool(found(first, second))
    assert there == bool(found(second, first))
    if there:
        assert repr(first) != repr(second)


@pytest.mark.parametrize(
    ("first", "second", "path", "size"),
    [
        ([1.0, 2.0], [1.0, 2.5], "[1]", 0.5),
        ({"a": {"b": 3}}, {"a": {"b": 1}}, "a.b", 2.0),
        ({"a": 1}, {}, "a", math.inf),
        ([1], [1, 2], " (length)", math.inf),
        (1.0, math.nan, "", math.inf),
        (True, 1, "", math.inf),
        ("a", "b", "", math.inf),
        (np.array([[0.0, 1.0], [2.0, 5.0]]), np.array([[0.0, 1.5], [2.0, 3.0]]), "[1, 1]", 2.0),
        (np.array([math.nan, 1.0]), np.array([1.0, 1.0]), "[0]", math.inf),
        (np.zeros(2), np.zeros(3), " (shape)", math.inf),
    ],
)
def test_differences_say_where_and_by_how_much(
    first: object, second: object, path: str, size: float
) -> None:
    (one,) = found(first, second)
    assert (one.path, one.size) == (path, size)


def test_not_a_number_is_equal_to_itself_and_zero_to_minus_zero() -> None:
    assert found(np.array([math.nan, 0.0, math.inf]), np.array([math.nan, -0.0, math.inf])) == []
    assert found(math.nan, math.nan) == found(0.0, -0.0) == []


def test_messages_differ_in_their_fields_but_for_those_left_out() -> None:
    first = JointCommand(tick=1, position=np.array([0.0, 1.0]))
    second = JointCommand(tick=2, position=np.array([0.0, 1.25]))
    assert [one.path for one in found(first, second)] == ["tick", "position[1]"]
    assert [str(one) for one in found(first, second, "tick")] == [
        "position[1]: 1.0 and 1.25, 0.25 apart"
    ]
