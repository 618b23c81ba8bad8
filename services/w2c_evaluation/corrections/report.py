"""Tables and the box plot of the study."""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from math import hypot, sqrt
from pathlib import Path
from typing import Any

import numpy as np

from w2c_evaluation.corrections.eye import RING_PX, Pixel, distance
from w2c_evaluation.corrections.pictures import HEIGHT, WIDTH
from w2c_evaluation.corrections.trial import MOST_PROMPTS, PHASES, Prompt, Session, Trial
from w2c_evaluation.results import row

NO_DOT_PX = hypot(WIDTH, HEIGHT)
"""Where no dot is shown it is as far away as it can be: the diagonal of the picture"""
PAPER_PX = 21.0
"""Median at the 5th prompt in phase 2, eleven people, photographs (paper, "Pilot Study")"""
TOLERANCE_PX = RING_PX
TOLERANCE = 0.5
"""A dot so near to where it was expected, in pixels or as a share of the way, went as was meant"""
COLOURS = {1: "tab:blue", 2: "tab:orange"}


def distances(sessions: Sequence[Session], phase: int, count: int) -> list[float]:
    """Return the distance of each trial of a phase after so many prompts [px]."""
    return [_distance(trial, count) for trial in _trials(sessions, phase)]


def make_rows(sessions: Sequence[Session]) -> list[dict[str, Any]]:
    """Return the rows of the results file: phases, voices, kinds of phrasing."""
    rows: list[dict[str, Any]] = []
    for phase in _phases(sessions):
        case = f"phase{phase}"
        for count in range(1, MOST_PROMPTS + 1):
            values = distances(sessions, phase, count)
            rows.append(row(case, f"median_px_prompt{count}", values, "px"))
        last = distances(sessions, phase, MOST_PROMPTS)
        trials = list(_trials(sessions, phase))
        rows.append(_share(case, "on_target", [value <= RING_PX for value in last]))
        said = [len(trial.prompts) for trial in trials]
        rows.append(row(case, "prompts_said", [float(count) for count in said], "count"))
        asked = sum(prompt.asks for trial in trials for prompt in trial.prompts)
        rows.append(row(case, "questions", [float(asked)], "count", n=sum(said)))
        for voice in _voices(sessions):
            own = [session for session in sessions if session.voice == voice]
            values = distances(own, phase, MOST_PROMPTS)
            rows.append(row(f"{case}.{voice}", f"median_px_prompt{MOST_PROMPTS}", values, "px"))
        for kind, prompts in by_kind(sessions, phase).items():
            rows.append(_share(f"{case}.{kind}", "as_meant", [good for _, good in prompts]))
    return rows


def by_kind(sessions: Sequence[Session], phase: int) -> dict[str, list[tuple[Prompt, bool]]]:
    """Return kind of phrasing -> prompts, each with whether the dot went where it was meant to."""
    found: dict[str, list[tuple[Prompt, bool]]] = defaultdict(list)
    for trial in _trials(sessions, phase):
        before: Pixel | None = None
        for prompt in trial.prompts:
            if not prompt.asks and prompt.kind != "cancel":
                found[prompt.kind].append((prompt, as_meant(prompt, before)))
            before = prompt.point
    return dict(sorted(found.items()))


def as_meant(prompt: Prompt, before: Pixel | None) -> bool:
    """Tell whether the dot went about where who spoke expected it.

    Args:
        prompt: What was said, and what came of it.
        before: The dot until then; None: there was none.
    """
    if not prompt.ok or prompt.point is None or prompt.wanted is None:
        return False
    way = 0.0 if before is None else distance(before, prompt.wanted)
    return distance(prompt.point, prompt.wanted) <= max(TOLERANCE_PX, TOLERANCE * way)


def median_interval(values: Sequence[float]) -> tuple[float, float]:
    """Return the 95 % interval of a median, from the order of the values."""
    ordered = sorted(values)
    half = 0.98 * sqrt(len(ordered))
    low = max(0, int(len(ordered) / 2 - half))
    high = min(len(ordered) - 1, int(np.ceil(len(ordered) / 2 + half)))
    return ordered[low], ordered[high]


def format_tables(sessions: Sequence[Session]) -> str:
    """Return Markdown tables: distance by prompt, by voice, and what was understood."""
    return "\n\n".join([_prompts_table(sessions), _voices_table(sessions), _kinds_table(sessions)])


def draw_boxes(sessions: Sequence[Session], paths: Sequence[Path]) -> None:
    """Draw the distance by prompt as the paper's box plot, as PNG or SVG by the files' names."""
    import matplotlib as mpl

    mpl.use("Agg")
    mpl.rcParams["svg.hashsalt"] = "corrections"
    from matplotlib import pyplot as plt
    from matplotlib.patches import Patch

    phases = _phases(sessions)
    figure, axis = plt.subplots(figsize=(7.2, 4.6), layout="constrained")
    width = 0.7 / len(phases)
    for place, phase in enumerate(phases):
        shift = (place - 0.5 * (len(phases) - 1)) * (width + 0.05)
        counts = range(1, MOST_PROMPTS + 1)
        axis.boxplot(
            [np.maximum(distances(sessions, phase, count), 1.0) for count in counts],
            positions=[count + shift for count in counts],
            widths=width,
            whis=(5, 95),
            showfliers=False,
            patch_artist=True,
            boxprops={"facecolor": COLOURS[phase], "alpha": 0.55},
            medianprops={"color": "black", "linewidth": 1.8},
        )
    axis.axhline(RING_PX, color="tab:green", linestyle="--", linewidth=1.2)
    axis.plot([MOST_PROMPTS + 0.48], [PAPER_PX], "D", color="black", markersize=5)
    axis.set_yscale("log")
    axis.set_ylim(1.0, 1.1 * NO_DOT_PX)
    ticks = (1, 2, 5, 10, 18, 50, 100, 200, 500, 1000)
    axis.set_yticks(ticks, [str(tick) for tick in ticks])
    axis.minorticks_off()
    axis.set_xticks(range(1, MOST_PROMPTS + 1), [str(i) for i in range(1, MOST_PROMPTS + 1)])
    axis.set_xlabel("prompt")
    axis.set_ylabel("distance from the target [px]")
    axis.grid(visible=True, axis="y", alpha=0.3)
    told = {1: "phase 1: names places only", 2: "phase 2: may correct"}
    handles: list[Any] = [
        Patch(facecolor=COLOURS[phase], alpha=0.55, label=told[phase]) for phase in phases
    ]
    handles.append(
        mpl.lines.Line2D([], [], color="tab:green", linestyle="--", label="target, 18 px")
    )
    people = "paper: people on photographs, phase 2"
    handles.append(mpl.lines.Line2D([], [], color="black", marker="D", linestyle="", label=people))
    figure.legend(handles=handles, loc="outside lower center", ncols=2, fontsize=8, frameon=False)
    axis.set_title(
        f"Box: quartiles and median; whiskers: 5 and 95 %; no dot: {NO_DOT_PX:.0f} px", fontsize=9
    )
    for path in paths:
        path.parent.mkdir(parents=True, exist_ok=True)
        metadata = {"Date": None} if path.suffix == ".svg" else {"Software": None}
        figure.savefig(path, dpi=130, metadata=metadata)
    plt.close(figure)


def _prompts_table(sessions: Sequence[Session]) -> str:
    head = ["phase", "n", *(f"prompt {i}" for i in range(1, MOST_PROMPTS + 1)), "on target"]
    lines = [_line(head), _rule(head)]
    for phase in _phases(sessions):
        cells = [str(phase), str(len(distances(sessions, phase, 1)))]
        for count in range(1, MOST_PROMPTS + 1):
            low, median, high = np.percentile(distances(sessions, phase, count), (25, 50, 75))
            cells.append(f"{median:.0f} [{low:.0f}, {high:.0f}]")
        last = distances(sessions, phase, MOST_PROMPTS)
        lines.append(_line([*cells, f"{np.mean([value <= RING_PX for value in last]):.2f}"]))
    sure = [
        f"phase {phase}: {low:.0f} to {high:.0f} px"
        for phase in _phases(sessions)
        for low, high in [median_interval(distances(sessions, phase, MOST_PROMPTS))]
    ]
    return (
        "Distance from the target [px], median [25 %, 75 %]. On target: at most "
        f"{RING_PX:.0f} px after prompt {MOST_PROMPTS}.\n\n"
        + "\n".join(lines)
        + f"\n\n95 % interval of the last median: {'; '.join(sure)}. "
        f"Paper, eleven people, photographs, phase 2: {PAPER_PX:.0f} px."
    )


def _voices_table(sessions: Sequence[Session]) -> str:
    phases = _phases(sessions)
    head = ["voice", *(f"phase {phase}" for phase in phases)]
    lines = [_line(head), _rule(head)]
    for voice in _voices(sessions):
        own = [session for session in sessions if session.voice == voice]
        cells = [voice]
        for phase in phases:
            values = distances(own, phase, MOST_PROMPTS)
            low, median, high = np.percentile(values, (25, 50, 75))
            cells.append(f"{median:.0f} [{low:.0f}, {high:.0f}]")
        lines.append(_line(cells))
    return f"After prompt {MOST_PROMPTS}, by voice [px].\n\n" + "\n".join(lines)


def _kinds_table(sessions: Sequence[Session]) -> str:
    head = ["phrasing", "phase", "n", "as meant", "not answered", "other module"]
    lines = [_line(head), _rule(head)]
    for phase in _phases(sessions):
        for kind, prompts in by_kind(sessions, phase).items():
            good = sum(ok for _, ok in prompts)
            failed = sum(not prompt.ok for prompt, _ in prompts)
            strayed = sum(_strayed(prompt) for prompt, _ in prompts)
            n = len(prompts)
            share = f"{good / n:.2f}"
            lines.append(_line([kind, str(phase), str(n), share, str(failed), str(strayed)]))
    return (
        "As meant: the dot came as near as half of the way, or 18 px, to where who spoke expected "
        "it.\n\n" + "\n".join(lines)
    )


INSTRUCTING = ("on", "side", "edge", "corner", "beside", "beside_length", "between")


def _strayed(prompt: Prompt) -> bool:
    """Tell whether words went to another module than they were for."""
    if not prompt.ok or prompt.kind in ("answer", "cancel"):
        return False
    return prompt.module.startswith("prediction") != (prompt.kind in INSTRUCTING)


def _share(case: str, metric: str, values: Sequence[bool]) -> dict[str, Any]:
    share = sum(values) / len(values) if values else 0.0
    return row(case, metric, [share], "rate", n=len(values))


def _trials(sessions: Sequence[Session], phase: int) -> Iterator[Trial]:
    return (trial for one in sessions if one.phase == phase for trial in one.trials)


def _distance(trial: Trial, count: int) -> float:
    found = trial.distance_after(count)
    return NO_DOT_PX if found is None else found


def _phases(sessions: Sequence[Session]) -> list[int]:
    return [phase for phase in PHASES if any(one.phase == phase for one in sessions)]


def _voices(sessions: Sequence[Session]) -> list[str]:
    return list(dict.fromkeys(one.voice for one in sessions))


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _rule(cells: Sequence[str]) -> str:
    return "|" + "---|" * len(cells)
