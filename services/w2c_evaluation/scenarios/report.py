"""Rows, table and printed lines of the scenarios, with their failures by cause."""

from collections import Counter
from collections.abc import Sequence
from math import sqrt
from typing import Any

import numpy as np

from w2c_evaluation.results import row
from w2c_evaluation.scenarios.record import CAUSES, RunResult

ALL = "all"
Z_95 = 1.96
TURN_CAUSES = ("words", "vision", "geometry")


def wilson(successes: int, trials: int) -> tuple[float, float]:
    """Return the 95 % Wilson interval of a rate; all of 0 to 1 without trials."""
    if trials == 0:
        return 0.0, 1.0
    rate = successes / trials
    scale = 1.0 + Z_95**2 / trials
    middle = (rate + Z_95**2 / (2 * trials)) / scale
    half = Z_95 * sqrt(rate * (1.0 - rate) / trials + Z_95**2 / (4 * trials**2)) / scale
    # Exact where rounding would leave a hair: without a success 0 is inside, without a failure 1.
    low = middle - half if successes else 0.0
    high = middle + half if successes < trials else 1.0
    return low, high


def make_rows(results: Sequence[RunResult]) -> list[dict[str, Any]]:
    """Return the rows of the results file: each scenario that was run, then all."""
    rows = []
    for case, runs in by_case(results).items():
        n = len(runs)
        counts = {
            "succeeded": sum(run.succeeded for run in runs),
            "falls": sum(run.fell for run in runs),
            "unconfirmed_motions": sum(run.unconfirmed_motions for run in runs),
            **{f"failed_{cause}": sum(run.cause == cause for run in runs) for cause in CAUSES},
        }
        rows += [row(case, name, [float(value)], "count", n=n) for name, value in counts.items()]
        low, high = wilson(counts["succeeded"], n)
        rate = row(case, "success_rate", [counts["succeeded"] / n], "rate", n=n)
        rows.append({**rate, "spread": [low, high]})
        corrections = [float(count) for run in runs for count in run.corrections]
        rows.append(row(case, "corrections", corrections, "count"))
        errors = [error for run in runs if run.succeeded for error in run.hand_errors_mm]
        rows.append(row(case, "hand_error", errors, "mm"))
        forces = [run.support_force_n[1] for run in runs if run.support_force_n]
        rows.append(row(case, "support_force", forces, "N"))
        seconds = [t.seconds for run in runs for turns in run.turns for t in turns]
        rows.append(row(case, "say_to_answer", seconds, "s"))
        turns = _count_turns(runs)
        for cause in TURN_CAUSES:
            wrong = sum(run.wrong_turns.get(cause, 0) for run in runs)
            rows.append(row(case, f"turns_wrong_{cause}", [float(wrong)], "count", n=turns))
        for asks, count in _count_questions(runs).items():
            rows.append(row(case, f"questions_{asks}", [float(count)], "count", n=turns))
    return rows


def by_case(results: Sequence[RunResult]) -> dict[str, list[RunResult]]:
    """Return the runs of each scenario, and of all."""
    names = sorted({result.scenario for result in results})
    cases = {name: [r for r in results if r.scenario == name] for name in names}
    return {**cases, ALL: list(results)} if results else {}


def format_table(results: Sequence[RunResult]) -> str:
    """Return a Markdown table of the scenarios, and a list of the failures."""
    lines = [
        "| scenario | succeeded | rate, 95 % interval | falls | unconfirmed motions | "
        "corrections | hand error [mm] | support [N] | failures | "
        "turns answered wrongly: words, vision, geometry | questions asked: answered, open |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for case, runs in by_case(results).items():
        good = sum(run.succeeded for run in runs)
        low, high = wilson(good, len(runs))
        causes = Counter(run.cause for run in runs if not run.succeeded)
        failures = ", ".join(f"{cause} {n}" for cause, n in causes.most_common()) or "none"
        corrections = [count for run in runs for count in run.corrections]
        errors = [error for run in runs if run.succeeded for error in run.hand_errors_mm]
        forces = [run.support_force_n[1] for run in runs if run.support_force_n]
        wrong = [str(sum(r.wrong_turns.get(cause, 0) for r in runs)) for cause in TURN_CAUSES]
        lines.append(
            f"| {case} | {good} of {len(runs)} | {good / len(runs):.2f} [{low:.2f}, {high:.2f}] | "
            f"{sum(run.fell for run in runs)} | {sum(run.unconfirmed_motions for run in runs)} | "
            f"{_mean(corrections)} | {_median(errors)} | {_median(forces)} | {failures} | "
            f"{', '.join(wrong)} of {_count_turns(runs)} | "
            f"{', '.join(str(count) for count in _count_questions(runs).values())} |"
        )
    failed = [run for run in results if not run.succeeded]
    if failed:
        lines += ["", "| failed run | cause | what happened | recording |", "|---|---|---|---|"]
        lines += [
            f"| {run.scenario}, seed {run.seed} | {run.cause} | "
            f"{'; '.join(run.problems).replace('|', '/')} | {run.recording or 'none'} |"
            for run in failed
        ]
    return "\n".join(lines)


def describe(result: RunResult) -> str:
    """Return one run on one line."""
    said = "+".join(str(count) for count in result.corrections) or "0"
    head = f"scenario {result.scenario}, seed {result.seed}: "
    tail = f" ({said} corrections, {result.seconds:.0f} s)"
    if result.succeeded:
        errors = ", ".join(f"{error:.0f}" for error in result.hand_errors_mm)
        return f"{head}succeeded, hands within {errors} mm{tail}"
    return f"{head}failed from {result.cause}: {'; '.join(result.problems)}{tail}"


def _count_turns(runs: Sequence[RunResult]) -> int:
    return sum(len(turns) for run in runs for turns in run.turns)


def _count_questions(runs: Sequence[RunResult]) -> dict[str, int]:
    """Return how often the robot asked back: what the operator answered, and what stayed open."""
    asks = Counter(turn.asks for run in runs for turns in run.turns for turn in turns)
    return {"answered": asks["answered"], "open": asks["open"]}


def _mean(values: Sequence[float]) -> str:
    return f"{np.mean(values):.1f}" if values else "-"


def _median(values: Sequence[float]) -> str:
    return f"{np.median(values):.0f}" if values else "-"
