"""Tables and a heat map of the trials, beside what was published."""

from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from w2c_evaluation.results import row
from w2c_evaluation.robustness.grid import MASSES, MODES, PUBLISHED, SPEEDS, Mode, TrialResult

TITLES: dict[Mode, str] = {
    "no_force_control": "no force control",
    "no_torque_limit": "force control, no torque limit",
    "full": "full",
}


def make_rows(results: Sequence[TrialResult]) -> list[dict[str, Any]]:
    """Return the rows of the results file: totals by mode, causes, then each cell."""
    rows = []
    for mode in MODES:
        trials = [result for result in results if result.cell.mode == mode]
        if not trials:
            continue
        rows.append(_count(mode, "survived", sum(r.survived for r in trials), len(trials)))
        causes = Counter(r.cause for r in trials if not r.survived)
        rows += [_count(mode, cause, n, len(trials)) for cause, n in sorted(causes.items())]
    for mode, speed, mass in _cells(results):
        trials = in_cell(results, mode, speed, mass)
        case = f"{mode}.{speed:g}_m_s.{mass:g}_kg"
        rows.append(_count(case, "survived", sum(r.survived for r in trials), len(trials)))
        rows.append(row(case, "reached", [r.reached for r in trials], "share"))
        speeds = [r.achieved_speed for r in trials if r.achieved_speed > 0.0]
        rows.append(row(case, "achieved_speed", speeds, "m/s"))
        rows.append(row(case, "top_speed", [r.top_speed for r in trials], "m/s"))
    return rows


def in_cell(
    results: Iterable[TrialResult], mode: Mode, speed: float, mass: float
) -> list[TrialResult]:
    """Return the trials of one cell."""
    wanted = (mode, speed, mass)
    return [r for r in results if (r.cell.mode, r.cell.speed, r.cell.mass) == wanted]


def format_tables(results: Sequence[TrialResult]) -> str:
    """Return one Markdown table a mode: survived of n, published of 10, achieved speed."""
    parts = []
    for mode in MODES:
        masses = sorted({r.cell.mass for r in results if r.cell.mode == mode})
        speeds = sorted({r.cell.speed for r in results if r.cell.mode == mode})
        if not masses:
            continue
        trials = [r for r in results if r.cell.mode == mode]
        total = sum(r.survived for r in trials)
        published = sum(sum(line) for line in PUBLISHED[mode])
        causes = Counter(r.cause for r in trials if not r.survived)
        failures = ", ".join(f"{cause} {n}" for cause, n in causes.most_common()) or "none"
        lines = [
            f"### {TITLES[mode]}: {total} of {len(trials)} (published: {published} of 250)",
            "",
            "| commanded [m/s] | " + " | ".join(f"{mass:g} kg" for mass in masses) + " |",
            "|---" * (len(masses) + 1) + "|",
        ]
        for speed in speeds:
            texts = [_cell_text(results, mode, speed, mass) for mass in masses]
            lines.append(f"| {speed:g} | " + " | ".join(texts) + " |")
        lines += ["", f"Failures: {failures}."]
        parts.append("\n".join(lines))
    return "\n\n".join(parts)


def draw_heat_map(results: Sequence[TrialResult], path: Path) -> None:
    """Draw the share that survived, each mode beside the published one, as PNG."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(2, len(MODES), figsize=(11, 6.4), sharex=True, sharey=True)
    for column, mode in enumerate(MODES):
        ours = np.full((len(SPEEDS), len(MASSES)), np.nan)
        for i, speed in enumerate(SPEEDS):
            for j, mass in enumerate(MASSES):
                trials = in_cell(results, mode, speed, mass)
                if trials:
                    ours[i, j] = np.mean([r.survived for r in trials])
        shares = (np.array(PUBLISHED[mode]) / 10.0, ours)
        for axis, values, title in zip(
            axes[:, column], shares, ("published", "this controller"), strict=True
        ):
            axis.imshow(values, vmin=0.0, vmax=1.0, cmap="RdYlGn", aspect="auto")
            for (i, j), value in np.ndenumerate(values):
                text = "-" if np.isnan(value) else f"{100 * value:.0f}"
                axis.text(j, i, text, ha="center", va="center")
            known = values[~np.isnan(values)]
            mean = f"{100 * known.mean():.0f} %" if known.size else "not run"
            axis.set_title(f"{TITLES[mode]}\n{title}: {mean}")
            axis.set_xticks(range(len(MASSES)), [f"{mass:g}" for mass in MASSES])
            axis.set_yticks(range(len(SPEEDS)), [f"{100 * speed:g}" for speed in SPEEDS])
    for axis in axes[-1]:
        axis.set_xlabel("unknown mass in the hand [kg]")
    for axis in axes[:, 0]:
        axis.set_ylabel("hand speed [cm/s]")
    figure.suptitle("Far reaches without a fall [%]")
    figure.tight_layout()
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110, metadata={"Software": None})
    plt.close(figure)


def _cells(results: Iterable[TrialResult]) -> list[tuple[Mode, float, float]]:
    order = {mode: index for index, mode in enumerate(MODES)}
    found = {(r.cell.mode, r.cell.speed, r.cell.mass) for r in results}
    return sorted(found, key=lambda cell: (order[cell[0]], *cell[1:]))


def _cell_text(results: Sequence[TrialResult], mode: Mode, speed: float, mass: float) -> str:
    trials = in_cell(results, mode, speed, mass)
    if not trials:
        return "-"
    text = f"{sum(r.survived for r in trials)}/{len(trials)}"
    if speed in SPEEDS and mass in MASSES:
        text += f" ({PUBLISHED[mode][SPEEDS.index(speed)][MASSES.index(mass)]}/10)"
    speeds = [r.achieved_speed for r in trials if r.achieved_speed > 0.0]
    return f"{text} {np.median(speeds):.2f} m/s" if speeds else text


def _count(case: str, metric: str, value: int, n: int) -> dict[str, Any]:
    return row(case, metric, [float(value)], "count", n=n)
