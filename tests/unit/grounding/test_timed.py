"""What answers cost, and the line that says so."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from fakes.vision import FakeFamily
from w2c_grounding.metrics import Metrics
from w2c_grounding.timed import TimedFamily, Times

IMAGE = np.zeros((3, 4, 3), np.uint8)


def every_ms(milliseconds: Iterator[float]) -> Any:
    return lambda: int(next(milliseconds) * 1e6)


def test_picture_and_phrases_are_timed_apart_and_a_known_picture_costs_nothing() -> None:
    family = TimedFamily(FakeFamily(), every_ms(iter([0.0, 20.0, 30.0, 35.0, 40.0, 41.0])))
    context = family.prepare(IMAGE)
    family.query(context, ["red"])
    new = family.take()
    assert (new.prepare_ms, new.query_ms) == pytest.approx((20.0, 5.0))
    family.query(context, ["blue"])
    known = family.take()
    assert (known.prepare_ms, known.query_ms) == pytest.approx((0.0, 1.0))
    assert (new.known, known.known) == (False, True)


def test_what_fails_is_timed_and_passed_on() -> None:
    def crash() -> None:
        raise ZeroDivisionError

    family = TimedFamily(FakeFamily(crash), every_ms(iter([0.0, 7.0])))
    with pytest.raises(ZeroDivisionError):
        family.query(IMAGE, ["red"])
    assert family.take().query_ms == pytest.approx(7.0)


def test_the_line_has_counts_and_medians() -> None:
    metrics = Metrics()
    assert metrics.summary() == ""
    for queue_ms, together in ((1.0, 1), (3.0, 2), (5.0, 2)):
        metrics.answered(queue_ms, together)
    metrics.worked(Times(20.0, 10.0, known=False))
    metrics.worked(Times(0.0, 12.0, known=True))
    assert metrics.summary() == (
        "3 answers, 2 of them with others; medians of the last 2: queue 3, picture 20, "
        "phrases 11 ms; 50 % of pictures known"
    )
