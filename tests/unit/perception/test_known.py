"""Which views can be judged, where states are not in the recording."""

import numpy as np
import pytest

from w2c.stance import SETTLED_NS, Feet, Stance
from w2c_perception.replaying.known import Known

STEP_NS = 10_000_000
BOTH, LEFT = (True, True), (True, False)
MISSING = "1 of the states that it was made of are not in the recording"


def stance(standing: Feet, world: int = 1) -> Stance:
    return Stance(standing, (np.eye(4), np.eye(4)), world)


def known(
    missing: tuple[int, ...] = (), feet: dict[int, Feet] | None = None, count: int = 10
) -> Known:
    """Return what is known after some states, of which some are missing."""
    made, before = Known(), None
    standing = BOTH
    for k in range(count):
        standing = (feet or {}).get(k, standing)
        if k in missing:
            made.lose()
            continue
        after = stance(standing)
        made.take(k * STEP_NS, before, after)
        before = after
    return made


@pytest.mark.parametrize("instant", [4.0, 4.5, 5.0])
@pytest.mark.parametrize("missing", range(10))
def test_it_matters_what_is_missing_among_the_two_states_before_and_after(
    instant: float, missing: int
) -> None:
    why_not = known((missing,)).why_not([round(instant * STEP_NS)], 1)
    # Of those that were there: the two before the instant; the one at or after it, and the next.
    after = int(np.ceil(instant))
    near = range(after - 2, after + 2)
    assert (why_not == MISSING) == (missing in near)


def test_colours_and_depth_count_once() -> None:
    assert known((3, 6)).why_not([4 * STEP_NS, 5 * STEP_NS], 1).startswith("2 of the states")
    assert known((4,)).why_not([4 * STEP_NS, 5 * STEP_NS], 1) == MISSING


def test_a_state_that_is_missing_at_the_end_matters_to_the_picture_there() -> None:
    assert known((9,)).why_not([8 * STEP_NS], 1) == MISSING
    assert known((9,)).why_not([7 * STEP_NS], 1) == ""


@pytest.mark.parametrize(
    ("changes", "unsure"),
    [(2, False), (3, True), (4, True), (9, True), (10, False)],
    ids=["before", "while", "right after", "while it may settle late", "long after"],
)
def test_feet_that_change_while_states_are_missing_stand_nobody_knows_where(
    changes: int, unsure: bool
) -> None:
    assert SETTLED_NS == 5 * STEP_NS
    made = known((3,), {changes: LEFT}, 15)
    assert bool(made.why_not([14 * STEP_NS], 1)) == unsure
    assert made.why_not([14 * STEP_NS], 2) == ""  # a new world begins with what is there


def test_a_world_that_began_with_missing_states_is_not_known() -> None:
    assert "where the feet stand" in known((0,)).why_not([9 * STEP_NS], 1)
    assert known((1,)).why_not([9 * STEP_NS], 1) == ""
