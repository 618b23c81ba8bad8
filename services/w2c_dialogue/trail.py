"""What a turn was made from: answers of models as they wrote them, and what they saw.

It goes with the turn into the recording, so that the point can be explained afterwards. Heatmaps
are in the recorded calls to grounding; the boxes that were chosen, and their order, in the target.
"""

from collections.abc import Sequence
from typing import Any

import msgspec

from w2c.messages import Evidence, ModelAnswer, PhraseEvidence, Sighting
from w2c_dialogue.interfaces import Choice

LONGEST_ANSWER = 2000
"""Characters; the whole text is in the recorded call"""
MOST_BOXES = 8


class Trail:
    """The evidence of one turn, as it comes in."""

    def __init__(self) -> None:
        self._answers: list[ModelAnswer] = []
        self._sightings: list[Sighting] = []
        self._vision_model = ""
        self.corrected_from: tuple[float, float] | None = None
        """Where the target was in the picture of the turn (u, v) [px]"""

    def wrote(self, task: str, value: Any, model: str) -> None:
        """Keep the value that a model answered with."""
        text = msgspec.json.encode(value).decode()[:LONGEST_ANSWER]
        self._answers.append(ModelAnswer(task=task, answer=text, model=model))

    def chose(self, task: str, choice: Choice, model: str) -> None:
        """Keep the option that a model chose, with the probability of each."""
        self._answers.append(
            ModelAnswer(
                task=task,
                answer=choice.option[:LONGEST_ANSWER],
                probabilities=choice.probabilities,
                model=model,
            )
        )

    def saw(self, evidence: Sequence[PhraseEvidence], model: str) -> None:
        """Keep what was found of phrases."""
        self._vision_model = model
        self._sightings += [
            Sighting(
                phrase=seen.phrase,
                found=seen.found,
                score=seen.score,
                boxes=seen.boxes[:MOST_BOXES],
                unknown_words=seen.unknown_words,
            )
            for seen in evidence
        ]

    def begin_with(self, earlier: "Trail") -> None:
        """Put what an earlier turn found in front: this one goes on from there."""
        self._answers = earlier._answers + self._answers
        self._sightings = earlier._sightings + self._sightings
        self._vision_model = self._vision_model or earlier._vision_model

    def evidence(self, prompts: str) -> Evidence | None:
        """Return all of it, of a turn with this prompt set; None where nobody was asked."""
        if not self._answers and not self._sightings:
            return None
        return Evidence(
            prompts=prompts,
            answers=self._answers,
            sightings=self._sightings,
            vision_model=self._vision_model,
            corrected_from=self.corrected_from,
        )
