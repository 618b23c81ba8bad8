"""How many outputs are as they were, how many are not, and which one was the first that is not."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from w2c.through import Compared, Skipped
from w2c_recorder.report import Report

MOST_SHOWN = 12
"""Places of one output in which it differs"""
COLUMNS = ("compared", "equal", "within", "DIFFER", "skipped")


@dataclass
class Count:
    """Of one kind of output."""

    equal: int = 0
    """Bit by bit"""
    within: int = 0
    """Not equal, and within the tolerance"""
    differ: int = 0
    largest: float = 0.0
    """Difference of all that is within [unit of the number]"""
    skipped: dict[str, int] = field(default_factory=dict)
    """Reason -> outputs"""

    @property
    def compared(self) -> int:
        """Outputs that were made again."""
        return self.equal + self.within + self.differ


class Tally:
    """Takes one result after the other."""

    def __init__(self, tolerance: float | None, start_s: float, end_s: float) -> None:
        self._tolerance = tolerance
        self._start_s = start_s
        self._end_s = end_s
        self.counts: dict[str, Count] = {}
        self.first: Compared | None = None
        """That differs"""

    def add(self, result: Compared | Skipped) -> None:
        """Count a result; those outside of the times are not counted."""
        if not self._start_s <= result.seconds <= self._end_s:
            return
        count = self.counts.setdefault(result.stream, Count())
        if isinstance(result, Skipped):
            count.skipped[result.reason] = count.skipped.get(result.reason, 0) + result.count
        elif result.differs(self._tolerance):
            count.differ += 1
            self.first = self.first or result
        elif result.found:
            count.within += 1
            largest = max(difference.size for difference in result.found)
            count.largest = max(count.largest, largest)
        else:
            count.equal += 1

    def report(self, title: str) -> Report:
        """Return what came of it; status 1 where something differs, or nothing was compared."""
        compared = any(count.compared for count in self.counts.values())
        lines = [title, *self._table()]
        if not compared:
            lines.append("NOTHING could be compared")
        if self.first is not None:
            lines += _first_lines(self.first)
        values = {
            "outputs": {stream: _values(count) for stream, count in self.counts.items()},
            "first_difference": None if self.first is None else _first_values(self.first),
        }
        return Report(lines, values, 0 if compared and self.first is None else 1)

    def _table(self) -> Iterator[str]:
        width = max((len(stream) for stream in self.counts), default=6)
        names = "".join(f"{name:>10}" for name in COLUMNS)
        yield f"{'output':<{width}}{names}"
        for stream, count in sorted(self.counts.items()):
            skipped = sum(count.skipped.values())
            numbers = count.compared, count.equal, count.within, count.differ, skipped
            yield f"{stream:<{width}}{''.join(f'{number:>10}' for number in numbers)}"
            if count.within:
                yield f"  largest difference within: {count.largest:.3g}"
            for reason, number in count.skipped.items():
                yield f"  skipped {number}: {reason}"


def _first_lines(first: Compared) -> list[str]:
    minutes, seconds = divmod(first.seconds, 60)
    lines = [
        "",
        f"FIRST DIFFERENCE: {first.stream}, {first.what}, at {minutes:.0f}:{seconds:06.3f}; "
        "recorded, and made now:",
    ]
    places = sorted(first.found, key=lambda difference: -difference.size)
    lines += [f"  {difference}" for difference in places[:MOST_SHOWN]]
    if len(places) > MOST_SHOWN:
        lines.append(f"  and {len(places) - MOST_SHOWN} more places")
    return [*lines, "made of:", *(f"  {line}" for line in first.inputs)]


def _values(count: Count) -> dict[str, Any]:
    return {
        "compared": count.compared,
        "equal": count.equal,
        "within": count.within,
        "differ": count.differ,
        "largest_within": count.largest,
        "skipped": count.skipped,
    }


def _first_values(first: Compared) -> dict[str, Any]:
    return {
        "output": first.stream,
        "which": first.what,
        "seconds": first.seconds,
        "places": [str(difference) for difference in first.found],
        "inputs": list(first.inputs),
    }
