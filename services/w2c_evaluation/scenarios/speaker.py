"""The scripted operator: looks, corrects, confirms, or gives up."""

from dataclasses import dataclass

import numpy as np

from w2c_evaluation.scenarios.answering import (
    SLACK_CM,
    Question,
    Wish,
    choose_option,
    in_other_words,
)
from w2c_evaluation.scenarios.scenario import Prompt
from w2c_evaluation.scenarios.sight import Circle, Pixel, Sight
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

    def __init__(
        self, rng: np.random.Generator, most: int = MOST_CORRECTIONS, beside_cm: float = 0.0
    ) -> None:
        """Begin.

        Args:
            rng: Chooses among what fits.
            most: Corrections, before it gives up.
            beside_cm: How far the wanted place is from the thing that is named [cm]; 0 = on it.
        """
        self._rng = rng
        self._beside_cm = beside_cm
        self._repeated = False
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

    def answer_question(
        self, question: Question, said: Prompt | Saying | Yes, wanted: Circle
    ) -> str | None:
        """Return the answer to a question of the robot; None: none of the options fits.

        Args:
            question: What is asked.
            said: What it was asked about.
            wanted: The place in the picture that was spoken about.
        """
        wish = Wish(
            wanted.centre,
            (SLACK_CM + self._beside_cm) * wanted.pixels_per_cm,
            beside=self._beside_cm > 0.0,
            changes=None if isinstance(said, Yes) else isinstance(said, Saying),
        )
        return choose_option(question, wish)

    def repeat(self, prompt: Prompt) -> Prompt | None:
        """Return a prompt in other words; None: it was said twice, or there are none."""
        if self._repeated:
            return None
        self._repeated = True
        return in_other_words(prompt)

    def _last_move(self, sight: Sight) -> Pixel | None:
        """Return how the point moved since the last correction; None before the first."""
        if self._before is None:
            return None
        return sight.shown[0] - self._before[0], sight.shown[1] - self._before[1]
