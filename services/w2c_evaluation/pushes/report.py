"""Tables and plots of the pushes."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from w2c_evaluation.pushes.cases import FORCES, PushResult
from w2c_evaluation.results import row


def make_rows(results: Sequence[PushResult]) -> list[dict[str, Any]]:
    """Return the rows of the results file: each case, then falls over all of them."""
    rows = []
    for name in dict.fromkeys(result.case.name for result in results):
        trials = [result for result in results if result.case.name == name]
        n = len(trials)
        rows.append(row(name, "falls", [float(sum(r.fell for r in trials))], "count", n=n))
        rows.append(row(name, "loaded", [float(sum(r.loaded for r in trials))], "count", n=n))
        for metric in ("mean_abs_error", "rms_error", "steady_error"):
            values = [getattr(r, metric) for r in trials]
            rows.append(row(name, metric, [v for v in values if np.isfinite(v)], "N"))
        if trials[0].case.friction < trials[0].case.stiffness * 0.5:
            rows += _slip_rows(name, trials)
    falls = float(sum(result.fell for result in results))
    rows.append(row("all", "falls", [falls], "count", n=len(results)))
    return rows


def _slip_rows(name: str, trials: Sequence[PushResult]) -> list[dict[str, Any]]:
    slipped = [r for r in trials if r.slip_seconds != -1.0]
    found = [r.slip_seconds for r in slipped if r.slip_seconds >= 0.0]
    n = len(trials)
    return [
        row(name, "slip", [1e3 * r.slip for r in trials], "mm"),
        row(name, "slipped", [float(len(slipped))], "count", n=n),
        row(name, "slips_found", [float(len(found))], "count", n=len(slipped)),
        row(name, "slip_found_after", found, "s"),
        row(
            name,
            "creep_found_after",
            [r.creep_seconds for r in trials if r.creep_seconds >= 0],
            "s",
        ),
    ]


def format_table(results: Sequence[PushResult]) -> str:
    """Return a Markdown table of the cases, medians over trials."""
    lines = [
        "| case | n | falls | loaded | mean abs [N] | rms [N] | steady state [N] | slip [mm] "
        "| found after [s] | creep found after [s] |",
        "|" + "---|" * 10,
    ]
    for name in dict.fromkeys(result.case.name for result in results):
        trials = [result for result in results if result.case.name == name]
        numbers = [
            float(np.median([getattr(r, metric) for r in trials]))
            for metric in ("mean_abs_error", "rms_error", "steady_error")
        ]
        found = [r.slip_seconds for r in trials if r.slip_seconds >= 0.0]
        crept = [r.creep_seconds for r in trials if r.creep_seconds >= 0.0]
        lines.append(
            f"| {name} | {len(trials)} | {sum(r.fell for r in trials)} "
            f"| {sum(r.loaded for r in trials)} | "
            + " | ".join(f"{value:.1f}" for value in numbers)
            + f" | {1e3 * max(r.slip for r in trials):.1f} "
            + f"| {f'{max(found):.2f}' if found else '-'} "
            + f"| {f'{max(crept):.2f}' if crept else '-'} |"
        )
    return "\n".join(lines)


def draw_pushes(results: Sequence[PushResult], path: Path) -> None:
    """Draw the true forces of the first trial of each push over time, as PNG."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(2, 2, figsize=(10, 6.4), sharex=True, sharey=True)
    for line, surface in enumerate(("table", "wall")):
        for column, (mode, title) in enumerate((("off", "without"), ("full", "with"))):
            axis = axes[line, column]
            for force, colour in zip(FORCES, ("tab:blue", "tab:orange", "tab:green"), strict=True):
                name = f"{surface}.{force:.0f}_N.{mode}"
                first = next((r for r in results if r.case.name == name), None)
                if first is None:
                    continue
                axis.plot(first.times, first.measured, color=colour, label=f"{force:.0f} N")
                axis.plot(first.times, first.wanted, color=colour, linestyle=":", linewidth=1)
                axis.axhline(force, color=colour, linewidth=0.5)
            axis.set_title(f"{surface}, {title} force control")
            axis.grid(visible=True, alpha=0.3)
    for axis in axes[-1]:
        axis.set_xlabel("time since the touch [s]")
    for axis in axes[:, 0]:
        axis.set_ylabel("force on the surface [N]")
    axes[0, 0].legend(title="commanded")
    figure.suptitle("Pushes of the right hand: true force (lines), force by the model (dotted)")
    figure.tight_layout()
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110, metadata={"Software": None})
    plt.close(figure)
