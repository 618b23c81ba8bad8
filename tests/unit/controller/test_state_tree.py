"""What is captured is restored bit by bit, in place."""

from collections import deque
from dataclasses import dataclass, field

import numpy as np
import pytest

import w2c_controller.snapshots.state_tree as module
from w2c.messages import Array
from w2c_controller.snapshots.state_tree import SnapshotError, capture, restore


@dataclass(frozen=True)
class Value:
    point: Array
    name: str


class Constant:
    def __init__(self) -> None:
        self.number = 1.0


class Part:
    def __init__(self) -> None:
        self.count = 0
        self.array = np.zeros(3)


@dataclass
class Whole:
    part: Part = field(default_factory=Part)
    constant: Constant = field(default_factory=Constant)
    value: Value | None = None
    table: dict[tuple[bool, bool], Part] = field(default_factory=dict)
    flags: list[bool] = field(default_factory=lambda: [False, False])
    queue: deque[float] = field(default_factory=lambda: deque([1.0]))
    shared: dict[int, Array] = field(default_factory=dict)
    step: object = print

    def __post_init__(self) -> None:
        self.same_part = self.part
        self.arguments = (self.part.array, self.part.array[:1])


for _kind in (Value, Constant, Part, Whole):
    _kind.__module__ = "w2c_controller.snapshots.state_tree"
    setattr(module, _kind.__qualname__, _kind)


def make() -> Whole:
    whole = Whole()
    whole.part.count = 7
    whole.part.array[:] = (0.1, np.nan, -0.0)
    whole.value = Value(np.arange(3.0), "goal")
    whole.table = {(True, False): Part()}
    whole.flags[1] = True
    whole.queue.append(2.0)
    whole.shared = {0: np.ones(2), 1: np.zeros(2)}
    whole.constant.number = 5.0
    return whole


def test_a_state_comes_back_bit_by_bit_into_the_same_arrays() -> None:
    whole, again = make(), Whole()
    array, flags = again.part.array, again.flags
    restore(again, capture(whole, constant=(Constant,)))
    assert again.part.array is array
    assert array.tobytes() == whole.part.array.tobytes()
    assert again.arguments[1][0] == 0.1
    assert again.flags is flags
    assert flags == [False, True]
    assert again.same_part is again.part
    assert again.part.count == 7
    assert again.value is not None
    assert again.value.name == "goal"
    assert list(again.queue) == [1.0, 2.0]
    assert again.constant.number == 1.0
    assert set(again.table) == {(True, False)}


def test_a_captured_state_does_not_change_with_the_object() -> None:
    whole = make()
    tree = capture(whole, constant=(Constant,))
    whole.part.array[:] = 9.0
    restore(whole, tree)
    assert whole.part.array[0] == 0.1


def test_one_array_in_two_places_becomes_two_where_values_differ() -> None:
    again, constant = Whole(), np.zeros(2)
    again.shared = {0: constant, 1: constant}
    restore(again, capture(make(), constant=(Constant,)))
    np.testing.assert_array_equal(again.shared[0], [1.0, 1.0])
    np.testing.assert_array_equal(again.shared[1], [0.0, 0.0])


def test_an_array_that_may_not_be_written_is_replaced() -> None:
    again, constant = Whole(), np.full(2, 3.0)
    constant.flags.writeable = False
    again.shared = {0: constant}
    restore(again, capture(make(), constant=(Constant,)))
    np.testing.assert_array_equal(constant, 3.0)
    np.testing.assert_array_equal(again.shared[0], 1.0)


def test_a_state_of_something_else_is_refused() -> None:
    with pytest.raises(SnapshotError, match="not of a"):
        restore(Part(), capture(make(), constant=(Constant,)))


def test_a_class_that_is_not_known_is_refused() -> None:
    tree = capture(make(), constant=(Constant,))
    tree["value"]["@"] = "os.Nothing"
    with pytest.raises(SnapshotError, match=r"os\.Nothing"):
        restore(Whole(), tree)
