"""Rows and table of the trials of a vision model."""

from collections.abc import Iterable, Sequence
from typing import Any, Protocol

import numpy as np

from w2c_evaluation.results import row
from w2c_evaluation.understanding.commands import wilson_interval

ABSENT = "absent"
TARGETS = {"hit": 0.95, "rejected": 0.90}


class Trial(Protocol):
    """One phrase asked about one picture."""

    @property
    def phrase_kind(self) -> str | None:
        """Return how the phrase names what it means."""

    @property
    def kind(self) -> str:
        """Return the kind of thing that was asked for; empty where nothing fits."""

    @property
    def unseen_kind(self) -> bool:
        """Whether training never showed the kind."""

    @property
    def unseen_pair(self) -> bool:
        """Whether training never showed the kind in this colour or of this material."""

    @property
    def score(self) -> float:
        """Return the peak of the heatmap."""

    @property
    def peak_hits(self) -> bool:
        """Whether the arg-max lies on what is meant."""

    @property
    def interior_hits(self) -> bool:
        """Whether the point of the default rule does."""

    @property
    def error(self) -> float:
        """Return how far the arg-max is from what is meant [px]."""


def make_rows(trials: Sequence[Trial], threshold: float) -> list[dict[str, Any]]:
    """Return the rows of the results file.

    Cases are `seen`, `unseen_kind`, `unseen_pair`, each also by phrase kind; `kind.KIND` of the
    seen; and `absent`.
    """
    present = [trial for trial in trials if trial.kind]
    groups = {
        "seen": [t for t in present if not t.unseen_kind and not t.unseen_pair],
        "unseen_kind": [t for t in present if t.unseen_kind],
        "unseen_pair": [t for t in present if t.unseen_pair and not t.unseen_kind],
    }
    rows: list[dict[str, Any]] = []
    for name, group in groups.items():
        if not group:
            continue
        rows.append(_rate(name, "hit", (t.peak_hits for t in group)))
        rows.append(_rate(name, "interior_hit", (t.interior_hits for t in group)))
        rows.append(_rate(name, "found", (t.score >= threshold for t in group)))
        both = (t.peak_hits and t.score >= threshold for t in group)
        rows.append(_rate(name, "found_and_hit", both))
        missed = [t.error for t in group if not t.peak_hits]
        rows.append(row(name, "error_of_misses", missed, "px"))
        errors = np.array([t.error for t in group])
        rows.append(row(name, "error_p95", [float(np.quantile(errors, 0.95))], "px", len(group)))
        for phrase_kind in sorted({str(t.phrase_kind) for t in group}):
            chosen = (t.peak_hits for t in group if t.phrase_kind == phrase_kind)
            rows.append(_rate(f"{name}.{phrase_kind}", "hit", chosen))
    rejected = [t.score < threshold for t in trials if not t.kind]
    if rejected:
        rows.append(_rate(ABSENT, "rejected", rejected))
    for kind in sorted({t.kind for t in groups["seen"]}):
        hits = (t.peak_hits for t in groups["seen"] if t.kind == kind)
        rows.append(_rate(f"kind.{kind}", "hit", hits))
    return rows


def format_table(rows: Sequence[dict[str, Any]]) -> str:
    """Return a Markdown table: rates with their 95 % intervals, medians with quartiles."""
    lines = ["| case | metric | value | 95 % | n | target |", "|---|---|---|---|---|---|"]
    for entry in rows:
        low, high = entry["spread"]
        target = ""
        if (entry["case"], entry["metric"]) in (("seen", "hit"), (ABSENT, "rejected")):
            target = f"{TARGETS[entry['metric']]:.2f}"
        digits = ".3f" if entry["unit"] == "rate" else ".1f"
        value = f"{entry['value']:{digits}}{'' if entry['unit'] == 'rate' else ' px'}"
        spread = f"{low:{digits}} to {high:{digits}}"
        cells = (entry["case"], entry["metric"], value, spread, str(entry["n"]), target)
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def _rate(case: str, metric: str, hits: Iterable[bool]) -> dict[str, Any]:
    """Return the row of a rate; its spread is the 95 % interval."""
    values = list(hits)
    return {
        "case": case,
        "metric": metric,
        "value": sum(values) / len(values),
        "unit": "rate",
        "n": len(values),
        "spread": list(wilson_interval(sum(values), len(values))),
    }
