"""Costs of vision models as rows, a table, and what misses its target."""

from collections.abc import Sequence
from typing import Any

from w2c_evaluation.results import origin, row

ONE_PHRASE_MS = 150.0
"""Target of the embedded model on a CPU"""

FIVE_TO_ONE = 1.5
"""Target of five phrases on one picture over one, of the embedded model"""

EMBEDDED = "embedded"


def make_rows(case: str, costs: Any) -> list[dict[str, Any]]:
    """Return the rows of one model.

    Args:
        case: Its name, and its device where that is no CPU.
        costs: Of `w2c_grounding.bench.costs.measure`.
    """
    rows = []
    for name, spent in costs.spent.items():
        rows.append(row(case, f"{name}_ms", spent.wall_ms, "ms"))
        rows.append(row(case, f"{name}_cpu_ms", spent.cpu_ms, "ms"))
    # What a GPU does is no processor time; on a CPU wall time is also that of others.
    clock = "cpu_ms" if costs.device == "cpu" else "wall_ms"
    one, five = (getattr(costs.spent[name], clock) for name in ("one_phrase", "five_phrases"))
    rows.append(row(case, "five_to_one", _ratios(five, one), "ratio"))
    rows.append(row(case, "load_s", [costs.load_s], "s"))
    rows.append(row(case, "rss_mb", [costs.memory_mb], "MB"))
    rows.append(row(case, "peak_rss_mb", [costs.peak_memory_mb], "MB"))
    if costs.peak_device_mb is not None:
        rows.append(row(case, "peak_device_mb", [costs.peak_device_mb], "MB"))
    return rows


def _ratios(above: Sequence[float], below: Sequence[float]) -> list[float]:
    """Return the ratio of each round, whose two numbers met the same machine."""
    return [a / b for a, b in zip(above, below, strict=True) if b > 0.0]


def missed(rows: Sequence[dict[str, Any]]) -> list[str]:
    """Return a line for each target that the embedded model misses."""
    value = {row["metric"]: row["value"] for row in rows if row["case"] == EMBEDDED}
    complaints = []
    # With the cores to itself it takes no longer than the processor time of all its threads, and
    # wall time on a machine that does other work says nothing.
    best = min(value.get("one_phrase_ms", 0.0), value.get("one_phrase_cpu_ms", 0.0))
    if best > ONE_PHRASE_MS:
        complaints.append(
            f"a phrase takes {value['one_phrase_ms']:.0f} ms, {value['one_phrase_cpu_ms']:.0f} ms "
            f"of processor time, target {ONE_PHRASE_MS:.0f}"
        )
    if value.get("five_to_one", 0.0) > FIVE_TO_ONE:
        complaints.append(
            f"five phrases take {value['five_to_one']:.2f} times as long as one, target "
            f"{FIVE_TO_ONE}"
        )
    return complaints


def format_table(results: dict[str, Any]) -> str:
    """Return a Markdown table with a line a model, medians of the rounds."""
    columns = {
        "one_phrase_ms": "one phrase",
        "one_phrase_cpu_ms": "its CPU time",
        "five_phrases_ms": "five phrases",
        "five_to_one": "five / one",
        "five_images_ms": "five pictures",
        "known_picture_ms": "known picture",
        "load_s": "load",
        "peak_rss_mb": "peak memory",
    }
    cases: dict[str, dict[str, dict[str, Any]]] = {}
    for entry in results["rows"]:
        cases.setdefault(entry["case"], {})[entry["metric"]] = entry
    lines = [
        f"| model | {' | '.join(columns.values())} |",
        "|---" * (len(columns) + 1) + "|",
    ]
    for case, metrics in cases.items():
        cells = [_cell(metrics.get(metric)) for metric in columns]
        lines.append(f"| {case} | {' | '.join(cells)} |")
    rounds = max((entry["n"] for entry in results["rows"]), default=0)
    note = f"Medians of {rounds} rounds; pictures of 1280 x 720, new phrases each time. "
    return "\n".join([*lines, "", note + origin(results)])


def _cell(entry: dict[str, Any] | None) -> str:
    if entry is None:
        return ""
    unit = "" if entry["unit"] == "ratio" else f" {entry['unit']}"
    return f"{entry['value']:.3g}{unit}" if entry["value"] < 100 else f"{entry['value']:.0f}{unit}"
