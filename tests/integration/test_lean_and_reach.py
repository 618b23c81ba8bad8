"""The point of the paper, in closed loop with the simulated robot: lean, and reach farther."""

import pytest

from support.leaning import lean_and_reach


@pytest.mark.slow
def test_the_cup_is_out_of_reach_on_two_feet_and_reached_leaning_on_the_book() -> None:
    outcome = lean_and_reach(seed=4)
    assert not outcome.fell
    assert outcome.first == "unreachable"
    assert outcome.gap_on_two_feet > 0.03
    assert outcome.lean == "loaded"
    assert outcome.second == "reached"
    assert outcome.gap_leaning <= 0.03
    assert outcome.hand_force > 15.0
    assert outcome.foot_drift < 0.005
    assert outcome.solver_failures == 0
    assert outcome.succeeded
