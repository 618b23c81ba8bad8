"""Who survived a reach, judged on made-up traces."""

import numpy as np
import pytest

from w2c.messages import Truth
from w2c_evaluation.robustness.grid import Target
from w2c_evaluation.robustness.survival import (
    Trace,
    achieved_speed,
    judge,
    reached,
    stands,
    top_speed,
)

TARGET = Target(
    trial=0, mass=0.0, start=(0.2, -0.4, 1.0), point=(0.7, -0.4, 1.0), direction=(1.0, 0.0, 0.0)
)
DEADLINE = 93.0


def truth(
    share: float,
    *,
    height: float = 1.0,
    tilt: float = 0.0,
    right_foot: float = 400.0,
    hand_force: float = 0.0,
    fell: bool = False,
) -> Truth:
    """Return what the simulator knows when the hand has come this share of the way."""
    positions = np.zeros((4, 3))
    positions[3] = np.array(TARGET.start) + share * np.array([0.5, 0.0, 0.0])
    forces = np.zeros((4, 3))
    forces[:, 2] = (480.0, right_foot, 0.0, hand_force)
    return Truth(
        stamp_ns=0,
        tick=0,
        generalized_position=np.zeros(33),
        world_from_base=np.array([0, 0, height, 0, np.sin(tilt / 2), 0, np.cos(tilt / 2)]),
        end_effector_positions=positions,
        contact_forces=forces,
        fell=fell,
    )


def trace_of(*samples: Truth, period: float = 0.5) -> Trace:
    trace = Trace(TARGET)
    for index, sample in enumerate(samples):
        trace.add(sample, index * period, hand=3)
    return trace


def there_and_back(share: float) -> list[Truth]:
    out = [truth(share * k / 10) for k in range(11)]
    return [*out, *reversed(out), *(truth(0.0) for _ in range(12))]


def test_there_and_back_and_standing_is_survived() -> None:
    assert judge(trace_of(*there_and_back(0.95)), DEADLINE) == ""


def test_ninety_percent_of_the_way_are_asked_for() -> None:
    assert judge(trace_of(*there_and_back(0.905)), DEADLINE) == ""
    assert judge(trace_of(*there_and_back(0.895)), DEADLINE) == "short"


def test_the_way_must_be_made_in_time() -> None:
    trace = trace_of(*there_and_back(0.95))
    assert judge(trace, deadline=4.0) == "short"
    assert reached(trace, 4.0) == pytest.approx(0.95 * 0.8)


def test_a_fall_counts_whatever_was_reached_before() -> None:
    samples = [*there_and_back(1.0), truth(1.2, fell=True)]
    assert judge(trace_of(*samples), DEADLINE) == "fell"


def test_a_fall_is_not_forgotten() -> None:
    samples = [truth(0.0, fell=True), *there_and_back(1.0)]
    assert judge(trace_of(*samples), DEADLINE) == "fell"


def test_a_hand_may_touch_nothing() -> None:
    samples = [truth(0.5, hand_force=30.0), *there_and_back(1.0)]
    assert judge(trace_of(*samples), DEADLINE) == "touched"


@pytest.mark.parametrize(
    "last",
    [
        truth(0.0, height=0.8),
        truth(0.0, tilt=0.5),
        truth(0.0, right_foot=5.0),
    ],
)
def test_it_must_stand_upright_on_both_feet_at_the_end(last: Truth) -> None:
    samples = [*there_and_back(1.0), *(last for _ in range(12))]
    assert judge(trace_of(*samples), DEADLINE) == "not_standing"


def test_it_must_be_at_rest_at_the_end() -> None:
    sinking = [truth(0.0, height=1.0 - 0.01 * k) for k in range(12)]
    trace = trace_of(*sinking, period=0.05)  # 0.2 m/s
    assert not stands(trace)


def test_an_empty_trace_stands_nowhere() -> None:
    assert not stands(Trace(TARGET))
    assert judge(Trace(TARGET), DEADLINE) == "short"


def test_achieved_speed_is_the_mean_of_the_middle_of_the_way() -> None:
    # 0.5 m in 5 s: 0.1 m/s
    trace = trace_of(*(truth(k / 100) for k in range(101)), period=0.05)
    assert achieved_speed(trace) == pytest.approx(0.1, rel=0.02)
    assert top_speed(trace) == pytest.approx(0.1, rel=0.02)


def test_no_speed_where_the_way_was_not_made() -> None:
    assert achieved_speed(trace_of(*there_and_back(0.5))) == -1.0


def test_progress_counts_along_the_way_only() -> None:
    aside = truth(0.0)
    aside.end_effector_positions[3] += (0.0, 0.4, 0.3)
    assert reached(trace_of(aside), DEADLINE) == pytest.approx(0.0, abs=1e-12)
