"""The base by the feet that stand: both, one, the other, none; nothing jumps, nothing drifts."""

import numpy as np
import pytest

from w2c.geometry import Matrix, inverse, transform
from w2c.stance import LOST_NS, SETTLED_NS, Soles, Stance, StanceEstimator, both_feet

BOTH, LEFT_ONLY, RIGHT_ONLY, NONE = (450.0, 450.0), (900.0, 0.0), (0.0, 900.0), (0.0, 0.0)
STEP_NS = 10_000_000


def turned(angle: float) -> Matrix:
    """Return a rotation (3, 3) about the vertical."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


class Walker:
    """A robot whose base and feet are put somewhere in the world, and what is told of it."""

    def __init__(self) -> None:
        self.base = transform(turned(0.1), [0.02, -0.01, 1.0])
        self.feet = [transform(np.eye(3), [0.0, side, 0.0]) for side in (0.1, -0.1)]
        self.estimator = StanceEstimator()
        self.stamp_ns = 0
        self.asked = 0

    def soles(self) -> Soles:
        self.asked += 1
        base_from_world = inverse(self.base)
        return base_from_world @ self.feet[0], base_from_world @ self.feet[1]

    def stand(self, forces: tuple[float, float], seconds: float = 0.3) -> Stance | None:
        stance = None
        for _ in range(round(seconds * 1e9 / STEP_NS)):
            self.stamp_ns += STEP_NS
            stance = self.estimator.update(self.stamp_ns, forces, self.soles)
        return stance

    def error(self, stance: Stance | None) -> float:
        """Return how far the estimate of the base is from the truth, as the largest entry."""
        assert stance is not None
        return float(np.abs(stance.world_from_base(self.soles()) - self.base).max())


def test_on_both_feet_the_world_is_midway_between_the_soles() -> None:
    walker = Walker()

    stance = walker.stand(BOTH)

    assert walker.error(stance) < 1e-12
    assert stance is not None and stance.standing == (True, True)


def test_the_base_may_move_while_the_feet_stand() -> None:
    walker = Walker()
    walker.stand(BOTH)
    walker.base = transform(turned(-0.2), [0.1, 0.05, 0.9])

    assert walker.error(walker.stand(BOTH)) < 1e-12
    assert walker.asked == 2  # once at the start, once by the test: nothing is computed meanwhile


@pytest.mark.parametrize(("forces", "foot"), [(RIGHT_ONLY, 0), (LEFT_ONLY, 1)])
def test_a_foot_in_the_air_has_no_say(forces: tuple[float, float], foot: int) -> None:
    walker = Walker()
    walker.stand(BOTH)

    walker.feet[foot] = transform(turned(0.3), [0.1, 0.2, 0.05])
    walker.base = transform(turned(0.05), [0.0, 0.08, 0.98])
    stance = walker.stand(forces)

    assert walker.error(stance) < 1e-12
    assert stance is not None and stance.standing == (foot == 1, foot == 0)


def test_a_foot_that_comes_down_elsewhere_stands_there_and_steps_go_on() -> None:
    walker = Walker()
    walker.stand(BOTH)
    for step in range(1, 6):
        foot = step % 2
        walker.stand(RIGHT_ONLY if foot == 0 else LEFT_ONLY)
        walker.feet[foot] = transform(turned(0.05 * step), [0.15 * step, 0.1 - 0.2 * foot, 0.0])
        walker.base = transform(turned(0.04 * step), [0.12 * step, 0.0, 0.95])
        stance = walker.stand(BOTH)
        assert walker.error(stance) < 1e-10


def test_a_foot_that_comes_down_where_it_stood_keeps_its_anchor() -> None:
    """Else every step in place would add the error of that moment: the world would drift."""
    walker = Walker()
    before = walker.stand(BOTH)
    for _ in range(20):
        walker.stand(RIGHT_ONLY)
        walker.feet[0][0, 3] += 1e-4  # joints that sag under one foot look like this
        walker.stand(BOTH)
        walker.feet[0][0, 3] -= 1e-4
    after = walker.stand(BOTH)

    assert before is not None and after is not None
    assert after.anchors[0] is before.anchors[0]


def test_between_the_thresholds_a_foot_stays_what_it_is() -> None:
    walker = Walker()
    walker.stand(BOTH)

    still = walker.stand((40.0, 860.0))
    walker.stand((5.0, 895.0))
    lifted = walker.stand((40.0, 860.0))

    assert still is not None and still.standing == (True, True)
    assert lifted is not None and lifted.standing == (False, True)


def test_a_knock_against_the_floor_is_no_stand() -> None:
    walker = Walker()
    walker.stand(BOTH)
    walker.stand(RIGHT_ONLY)

    knocked = walker.stand((300.0, 600.0), 0.8 * SETTLED_NS * 1e-9)

    assert knocked is not None and knocked.standing == (False, True)
    assert walker.stand((300.0, 600.0), 0.1) is not None
    assert walker.estimator.stance is not None
    assert walker.estimator.stance.standing == (True, True)


def test_without_a_foot_for_a_moment_the_last_stance_holds_then_nothing_is_known() -> None:
    walker = Walker()
    before = walker.stand(BOTH)

    assert walker.stand(NONE, 0.5 * LOST_NS * 1e-9) is before
    assert walker.stand(NONE, LOST_NS * 1e-9) is None

    walker.base = transform(turned(1.0), [3.0, 0.0, 1.0])
    after = walker.stand(BOTH)
    assert before is not None and after is not None
    assert after.world == before.world + 1  # set down anywhere: another world
    assert before.standing == after.standing


def test_a_sensor_without_numbers_leaves_its_foot_as_it_is() -> None:
    walker = Walker()
    walker.stand(BOTH)

    both = walker.stand((float("nan"), 450.0))
    walker.stand(RIGHT_ONLY)
    one = walker.stand((float("nan"), 450.0))

    assert both is not None and both.standing == (True, True)
    assert one is not None and one.standing == (False, True)


def test_first_seen_on_one_foot_the_other_is_taken_as_lifted_straight_up() -> None:
    walker = Walker()
    walker.feet[0] = transform(turned(0.2), [0.03, 0.1, 0.05])
    expected = Walker()
    expected.feet[0] = transform(turned(0.2), [0.03, 0.1, 0.0])

    one, both = walker.stand(RIGHT_ONLY), expected.stand(BOTH)

    assert one is not None and both is not None
    assert one.world_from_base(walker.soles()) == pytest.approx(
        both.world_from_base(expected.soles()), abs=1e-12
    )


def test_one_that_joins_later_goes_on_in_the_world_of_one_that_saw_the_steps() -> None:
    walker = Walker()
    walker.stand(BOTH)
    walker.stand(RIGHT_ONLY)
    walker.feet[0] = transform(turned(0.2), [0.2, 0.12, 0.0])
    walker.base = transform(turned(0.1), [0.1, 0.0, 0.98])
    known = walker.stand(BOTH)
    walker.estimator = StanceEstimator()
    own = walker.stand(BOTH)
    assert known is not None and own is not None
    assert walker.error(own) > 0.05, "midway between the soles is elsewhere after a step"

    walker.estimator.move(known.anchors)
    moved = walker.estimator.stance

    assert walker.error(moved) < 1e-12
    assert moved is not None and moved.world == own.world + 1
    walker.estimator.move(known.anchors)
    assert walker.estimator.stance is moved, "who agrees already stays"
    walker.base = transform(turned(-0.1), [0.12, 0.03, 0.97])
    assert walker.error(walker.stand(LEFT_ONLY)) < 1e-12


def test_where_no_foot_stands_nobody_can_join() -> None:
    estimator = StanceEstimator()
    estimator.move((np.eye(4), np.eye(4)))
    assert estimator.stance is None


def test_before_any_foot_stands_nothing_is_known() -> None:
    assert Walker().stand(NONE) is None


def test_the_estimate_survives_a_round_trip_of_frames() -> None:
    walker = Walker()
    stance = both_feet(walker.soles())

    middle = stance.world_from_base(walker.soles()) @ walker.soles()[0]

    assert middle == pytest.approx(stance.anchors[0], abs=1e-12)
