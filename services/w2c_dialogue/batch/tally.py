"""How many lines of a batch were answered, and how long they took."""

import statistics
from dataclasses import dataclass, field
from typing import Any

from w2c_dialogue.batch.lines import Answer, field_of

TASKS = ("select", "analyze", "effector", "relative", "correct", "dialogue")
MALFORMED = "malformed"
"""Case of the lines that name none of the tasks"""


@dataclass
class Tally:
    """Of the lines of one run, in the order of `TASKS`."""

    _seconds: dict[str, list[float]] = field(default_factory=dict)
    _answered: dict[str, int] = field(default_factory=dict)

    @property
    def failures(self) -> int:
        """Lines that were answered with an error."""
        return sum(map(len, self._seconds.values())) - sum(self._answered.values())

    def add(self, line: bytes, answer: Answer, seconds: float) -> None:
        """Count a line, what was written for it, and how long that took [s]."""
        task = field_of(line, "task")
        case = task if isinstance(task, str) and task in TASKS else MALFORMED
        self._seconds.setdefault(case, []).append(seconds)
        self._answered[case] = self._answered.get(case, 0) + ("error" not in answer)

    def results(self, seed: int) -> dict[str, Any]:
        """Return the document that `--json` writes; medians with their quartiles."""
        rows: list[dict[str, Any]] = []
        for case in (*TASKS, MALFORMED):
            taken = self._seconds.get(case)
            if not taken:
                continue
            rows.append(_row(case, "answered", self._answered[case], "count", len(taken)))
            low, median, high = (
                statistics.quantiles(taken, n=4, method="inclusive") if taken[1:] else taken * 3
            )
            rows.append(_row(case, "seconds", median, "s", len(taken)) | {"spread": [low, high]})
        return {"benchmark": "dialogue.batch", "seed": seed, "rows": rows}


def _row(case: str, metric: str, value: float, unit: str, n: int) -> dict[str, Any]:
    return {"case": case, "metric": metric, "value": value, "unit": unit, "n": n}
