"""Percentiles are values that were there."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from w2c.percentiles import percentiles


@given(st.integers(1, 5000), st.integers(0, 1000))
def test_each_is_a_value_at_or_below_the_exact_percentile(size: int, seed: int) -> None:
    values = np.random.default_rng(seed).normal(size=size)
    p50, p99 = np.percentile(values, (50, 99), method="lower")
    assert percentiles(values) == {"p50": p50, "p99": p99}


def test_nothing_measured_is_zero() -> None:
    assert percentiles(np.zeros(0)) == {"p50": 0.0, "p99": 0.0}
