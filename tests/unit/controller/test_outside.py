"""What the process finds is the same when it is made again from what was measured."""

import pytest

from w2c.errors import ControlError
from w2c_controller.safety.hazards import Hazard
from w2c_controller.safety.outside import found_outside, out_of_order, silence


@pytest.mark.parametrize("hazard", [silence(101.056336, 100.0), out_of_order(24, 26)])
def test_a_finding_follows_from_its_numbers(hazard: Hazard) -> None:
    assert found_outside(hazard.cause, float(hazard.value), float(hazard.limit)) == hazard


def test_what_the_controller_finds_itself_is_not_taken_from_a_report() -> None:
    with pytest.raises(ControlError, match="'stopped' is found by the controller in its states"):
        found_outside("stopped", 0.0, 0.0)
