"""The operator of the demo is asked."""

from typing import Any

import numpy as np
import pytest

from fakes.scenario_world import TABLE_M, THINGS, AskingProduct, Thing
from w2c.bus.inprocess import InProcessHub
from w2c_evaluation.demo.operator import MOST_REPETITIONS, Operator, ScenarioError
from w2c_evaluation.demo.scenario import SCENARIO_A, Line

PLACES = {thing.name: np.array([*thing.centre, TABLE_M]) for thing in THINGS}
OTHERS = (Thing("shelf", (0.2, 0.3), (0.1, 0.1, 0.0)), THINGS[1])
NOT_ASKED_ABOUT: Any = None
"""The robot's description"""


def say(lines: tuple[Line, ...], among: tuple[Thing, ...] = THINGS, *, late: int = 0) -> list[str]:
    """Return what a product heard that asks; it hesitates between these things."""
    hub = InProcessHub()
    product = AskingProduct(hub, among=among, late=late)
    with product:
        operator = Operator(hub.connect("evaluation"), NOT_ASKED_ABOUT, PLACES)
        operator.wait_until_it_stands(5.0)
        for line in lines:
            operator.perform(line)
    return product.heard


def test_the_operator_of_the_demo_says_which_thing_and_that_it_is_a_change() -> None:
    place, change = SCENARIO_A[:2]
    assert say((place, change)) == [place.text, "left", change.text, "change"]


def test_the_operator_of_the_demo_uses_other_words_where_no_answer_fits() -> None:
    place = SCENARIO_A[0]
    assert say((place,), OTHERS) == [place.text, place.again]


def test_a_yes_that_is_asked_about_ends_the_demo() -> None:
    place, _, perfect = SCENARIO_A[:3]
    with pytest.raises(ScenarioError, match="perfect"):
        say((place, perfect))


def test_a_line_that_came_too_late_is_said_again() -> None:
    place = SCENARIO_A[0]
    assert say((place,), late=2) == [place.text] * 3 + ["left"]


def test_a_service_that_is_always_late_ends_the_demo() -> None:
    with pytest.raises(ScenarioError, match="did not answer in time"):
        say(SCENARIO_A[:1], late=MOST_REPETITIONS + 1)
