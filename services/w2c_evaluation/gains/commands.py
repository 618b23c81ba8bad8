"""`w2c bench gains`."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Annotated, Any

import msgspec

from w2c.config import parse
from w2c_evaluation.gains.trial import METRICS, Case, Outcome, run_case
from w2c_evaluation.pool import run_all
from w2c_evaluation.results import make_results, row, write_results

GAINS: dict[str, dict[str, float | str]] = {
    "own": {},
    "off": {"mode": "off"},
    "model_only": {"proportional": 0.0, "damping": 0.0},
    "paper": {"proportional": 0.2, "damping": -0.02},
    "code": {"proportional": 0.2, "damping": 0.005},
    "undamped": {"proportional": 0.2, "damping": 0.0},
    "p0.5": {"proportional": 0.5, "damping": 0.0},
    "p1": {"proportional": 1.0, "damping": 0.0},
    "p1_plus": {"proportional": 1.0, "damping": 0.02},
    "p2": {"proportional": 2.0, "damping": 0.0},
    "filter0.05": {"complementary_hz": 0.05},
    "filter1": {"complementary_hz": 1.0},
    "ratio0.6": {"torque_ratio": 0.6, "torque_ratio_release": 0.5},
    "no_ratio": {"mode": "no_torque_limit"},
}
"""Sets of gains that are compared; every value not named is the controller's own."""


class GainsConfig(msgspec.Struct, frozen=True, kw_only=True):
    """Force feedback with other gains, on robots unlike their model, in the simulator."""

    gains: tuple[str, ...] = tuple(GAINS)
    """Sets of gains, by name."""
    stiffnesses: tuple[float, ...] = (0.7, 1.0, 1.4)
    """True joint stiffness over the one that the controller knows."""
    masses: tuple[float, ...] = (0.0,)
    """Unmodelled, in the reaching hand [kg]."""
    workers: Annotated[int, msgspec.Meta(ge=0, le=1024)] = 0
    """Processes; 0 = one a core."""
    json: str = ""
    """Write the results to this file."""


def bench(arguments: list[str] | None = None) -> int:
    """Run the comparison and print its table."""
    config = parse(GainsConfig, arguments or [], program="w2c bench gains")
    cases = [
        Case(name=name, gains=GAINS[name], stiffness=stiffness, hand_mass=mass)
        for stiffness in config.stiffnesses
        for mass in config.masses
        for name in config.gains
    ]
    tasks = [(case,) for case in cases]
    trials = run_all(run_case, tasks, workers=config.workers, title="trials")
    outcomes = sorted(trials, key=lambda outcome: cases.index(outcome.case))
    print(format_table(outcomes))
    if config.json:
        write_results(make_results("gains", 0, list(_rows(outcomes))), Path(config.json))
    return 0


def format_table(outcomes: Sequence[Outcome]) -> str:
    """Return a Markdown table, one line a trial."""
    lines = [
        "| gains | stiffness | mass | push | ripple | knock | reach | peak | hold | feet | end |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for o in outcomes:
        end = "fell" if o.fell else o.reason or f"{o.pushed}, {o.reached}"
        values = " | ".join(f"{getattr(o, metric):.1f}" for metric in METRICS)
        lines.append(
            f"| {o.case.name} | {o.case.stiffness:g} | {o.case.hand_mass:g} | {values} | {end} |"
        )
    return "\n".join(lines)


def _rows(outcomes: Iterable[Outcome]) -> Iterable[dict[str, Any]]:
    for o in outcomes:
        case = f"{o.case.name}.stiffness_{o.case.stiffness:g}.mass_{o.case.hand_mass:g}"
        for metric in METRICS:
            yield row(case, metric, [getattr(o, metric)], "N")
        yield row(case, "fell", [float(o.fell)], "count")
