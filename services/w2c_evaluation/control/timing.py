"""Times cases tick by tick, in turn, so that all of them meet the same moods of the machine."""

import gc
from collections.abc import Sequence
from typing import Any

import numpy as np

from w2c_evaluation.results import row

BLOCK = 200
"""Ticks of one case before the next one's turn."""
PARTS_SHARE = 10
"""One tick in so many is timed again, by parts."""
PINK = "pink.two_feet_hand.moving"

Times = dict[str, list[float]]


def time_cases(cases: Sequence[Any], ticks: int) -> tuple[Times, dict[str, Times]]:
    """Return the CPU time of each tick [us] by case; and by case and part, of ticks after those.

    Args:
        cases: What `control_cases` of the controller gives, and the like.
        ticks: Of each case.
    """
    blocks = -(-ticks // BLOCK)
    times: Times = {case.name: [] for case in cases}
    for case in cases:
        case.prepare()
    gc.collect()
    gc.freeze()
    gc.disable()
    try:
        for _ in range(blocks):
            for case in cases:
                times[case.name] += [1e-3 * case.step() for _ in range(BLOCK)]
        parts = {
            case.name: {
                part: [1e-3 * value for value in values]
                for part, values in case.time_parts(max(ticks // PARTS_SHARE, BLOCK)).items()
            }
            for case in cases
            if hasattr(case, "time_parts")
        }
    finally:
        gc.enable()
        gc.unfreeze()
    return times, parts


def make_rows(times: Times, parts: dict[str, Times]) -> list[dict[str, Any]]:
    """Return the rows of the results file."""
    rows = []
    for case, values in times.items():
        rows.append(row(case, "tick_cpu_median", values, "us"))
        rows.append(row(case, "tick_cpu_p99", [np.percentile(values, 99)], "us", n=len(values)))
        for part, part_values in parts.get(case, {}).items():
            rows.append(row(case, f"{part}_cpu_median", part_values, "us"))
            rows.append(
                row(
                    case,
                    f"{part}_cpu_p99",
                    [np.percentile(part_values, 99)],
                    "us",
                    n=len(part_values),
                )
            )
    return rows


def format_table(times: Times, parts: dict[str, Times]) -> str:
    """Return median and p99 of each case, as shares of pin-pink's, and the medians of its parts."""
    median, slowest = np.percentile(times[PINK], (50, 99))
    lines = ["case                        median [us]          p99 [us]"]
    for case, values in times.items():
        p50, p99 = np.percentile(values, (50, 99))
        shares = f"{p50:8.1f} ({p50 / median:4.2f} pink)  {p99:8.1f} ({p99 / slowest:4.2f} pink)"
        lines.append(f"{case:26s}{shares}")
        for part, part_values in parts.get(case, {}).items():
            lines.append(f"  {part:30s}{np.median(part_values):8.1f}")
    return "\n".join(lines)
