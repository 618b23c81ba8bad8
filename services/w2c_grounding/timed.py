"""A family whose work is timed."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from w2c_grounding.family import Evidence, Family, RgbImage


@dataclass(frozen=True)
class Times:
    """What one answer took."""

    prepare_ms: float
    """0 where the picture was known"""
    query_ms: float
    known: bool
    """The picture had been prepared before"""


class TimedFamily:
    """Does what the family does. One thread at a time."""

    def __init__(self, family: Family[Any], timer: Callable[[], int]) -> None:
        """Wrap a family.

        Args:
            family: Does the work.
            timer: Returns the time [ns].
        """
        self._family = family
        self._timer = timer
        self._prepare_ms: float | None = None
        self._query_ms = 0.0

    def take(self) -> Times:
        """Return what was spent since the last call."""
        prepare, query = self._prepare_ms, self._query_ms
        self._prepare_ms, self._query_ms = None, 0.0
        return Times(prepare or 0.0, query, prepare is None)

    def prepare(self, image: RgbImage) -> Any:
        """Return what the model keeps of a picture."""
        started = self._timer()
        try:
            return self._family.prepare(image)
        finally:
            self._prepare_ms = (self._timer() - started) * 1e-6

    def query(self, context: Any, phrases: Sequence[str]) -> list[Evidence]:
        """Return the evidence for each phrase."""
        started = self._timer()
        try:
            return self._family.query(context, phrases)
        finally:
            self._query_ms += (self._timer() - started) * 1e-6
