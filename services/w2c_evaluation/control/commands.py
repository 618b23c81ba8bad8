"""`w2c bench control`."""

from pathlib import Path
from typing import Annotated

import msgspec

from w2c.config import parse
from w2c_evaluation.control.timing import PINK, format_table, make_rows, time_cases
from w2c_evaluation.results import make_results, write_results


class ControlConfig(msgspec.Struct, frozen=True, kw_only=True):
    """CPU time of the controller's tick, beside inverse kinematics by pin-pink in the same run."""

    ticks: Annotated[int, msgspec.Meta(ge=200, le=10_000_000)] = 20_000
    """Timed ticks of each case."""
    seed: Annotated[int, msgspec.Meta(ge=0)] = 0
    """Of the noise on the sensors."""
    only: str = ""
    """Time the cases whose name holds this, and pin-pink; empty = all."""
    json: str = ""
    """Write the results to this file."""


def bench(arguments: list[str] | None = None) -> int:
    """Time all cases. Exit status 0 when the tick is within its budget, 1 when not."""
    from w2c.library import library

    config = parse(ControlConfig, arguments or [], program="w2c bench control")
    description = library("make_description")(lock_step=True)
    reference = library("inverse_kinematics")(description)
    cases = [
        case
        for case in library("control_cases")(description, config.seed)
        if config.only in case.name
    ]
    times, parts = time_cases([*cases, reference], config.ticks)
    rows = make_rows(times, parts)
    print(format_table(times, parts))
    if config.json:
        write_results(make_results("control", config.seed, rows), Path(config.json))
    over = over_budget(times)
    for line in over:
        print(line)
    return 1 if over else 0


BUDGET = (
    ("two_feet_hand.moving", "median", 50, 0.80),
    ("two_feet_hand.moving", "p99", 99, 0.62),
    ("two_feet_hand.stalled", "p99", 99, 0.70),
)
"""Case, statistic, its percentile, and its largest share of pin-pink's."""


def over_budget(times: dict[str, list[float]]) -> list[str]:
    """Return what exceeds the budget, in words."""
    import numpy as np

    lines = []
    for case, name, percentile, largest in BUDGET:
        if case in times:
            share = np.percentile(times[case], percentile) / np.percentile(times[PINK], percentile)
            if share > largest:
                lines.append(
                    f"{case}: {name} is {share:.2f} of pin-pink's, budget {largest:.2f}; the parts "
                    "above say where the time goes"
                )
    return lines
