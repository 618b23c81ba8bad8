"""The scripted operator: looks, corrects, confirms, or gives up."""

from dataclasses import dataclass

import numpy as np

from w2c_evaluation.scenarios.sight import Pixel, Sight
from w2c_evaluation.scenarios.wording import Saying, choose_words

MOST_CORRECTIONS = 6
YES = ("that's perfect", "yes", "yes, go there", "ok, that's it", "perfect")


@dataclass(frozen=True)
class Yes:
    """The point is where it is wanted."""

    text: str


@dataclass(frozen=True)
class GiveUp:
    """Enough was said."""

    reason: str


class Speaker:
    """Talks about one target. Knows what it sees and what it said, nothing else."""

    def __init__(self, rng: np.random.Generator, most: int = MOST_CORRECTIONS) -> None:
        self._rng = rng
        self._most = most
        self._before: Pixel | None = None
        self.corrections = 0

    def answer(self, sight: Sight) -> Saying | Yes | GiveUp:
        """Return what to say to a picture."""
        if sight.good:
            return Yes(YES[int(self._rng.integers(len(YES)))])
        if self.corrections >= self._most:
            du, dv = sight.error
            return GiveUp(
                f"after {self.corrections} corrections the point is still "
                f"({du:.0f}, {dv:.0f}) px from where it is wanted"
            )
        saying = choose_words(sight, self._last_move(sight), self._rng)
        if saying is None:
            return Yes(YES[0])
        self.corrections += 1
        self._before = sight.shown
        return saying

    def _last_move(self, sight: Sight) -> Pixel | None:
        """Return how the point moved since the last correction; None before the first."""
        if self._before is None:
            return None
        return sight.shown[0] - self._before[0], sight.shown[1] - self._before[1]
