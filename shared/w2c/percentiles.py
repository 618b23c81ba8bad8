"""Percentiles of what a loop measures about itself, for loops that run for days."""

import numpy as np
import numpy.typing as npt


def percentiles(values: npt.NDArray[np.float64]) -> dict[str, float]:
    """Return p50 and p99 of values (n,), in their unit; zeros where there are none.

    Each is one of the values: the lower one where numpy's own would interpolate between two. That
    takes four times as long, and its small allocations take thousands of calls to come to rest.
    """
    if not values.size:
        return {"p50": 0.0, "p99": 0.0}
    middle, high = (values.size - 1) // 2, (99 * (values.size - 1)) // 100
    parted = np.partition(values, (middle, high))
    return {"p50": float(parted[middle]), "p99": float(parted[high])}
