"""The family `pointer`: a vision-language model is asked where things are, and answers in words."""

import logging
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

from w2c.errors import ModelError
from w2c_grounding.family import Evidence, RgbImage
from w2c_grounding.pointer.options import PointerOptions
from w2c_grounding.pointer.places import Frame, evidence_of
from w2c_grounding.pointer.reading import Reading, read_answer
from w2c_grounding.pointer.talker import Shown, Talker, Turn
from w2c_grounding.wording import fill

_LOG = logging.getLogger("w2c.grounding.pointer")

BARE_TEMPLATE = "{}"
"""Of a model without a template of its own: it gets the question below"""

QUESTIONS = {
    "points": (
        "Point to each {} in the picture. Answer with JSON and nothing else: a list of "
        '{"point_2d": [x, y]}, one for each, its middle; x goes from 0 at the left edge of the '
        "picture to 1000 at the right, y from 0 at the top to 1000 at the bottom. "
        "If the picture does not show any, answer []."
    ),
    "boxes": (
        "Find each {} in the picture. Answer with JSON and nothing else: a list of "
        '{"bbox_2d": [left, top, right, bottom]}, one for each; across from 0 at the left edge of '
        "the picture to 1000 at the right, down from 0 at the top to 1000 at the bottom. "
        "If the picture does not show any, answer []."
    ),
}

AGAIN = (
    "That names no place. Answer with JSON and nothing else, as asked; [] if the picture does not "
    "show any."
)


@dataclass(frozen=True)
class PointerContext:
    """A picture as the model gets it, and its size [px]."""

    width: int
    height: int
    shown: Shown


class Pointer:
    """A model that answers with coordinates. Thread-safe where its talker is."""

    def __init__(self, talker: Talker, options: PointerOptions, template: str) -> None:
        self._talker = talker
        self._options = options
        own = template.strip() == BARE_TEMPLATE
        self._question = QUESTIONS[options.ask_for] if own else template

    def prepare(self, image: RgbImage) -> PointerContext:
        """Make the picture that is sent with every question."""
        return PointerContext(image.shape[1], image.shape[0], self._talker.show(image))

    def query(self, context: PointerContext, phrases: Sequence[str]) -> list[Evidence]:
        """Ask for each phrase, several at once where the model takes it.

        Raises:
            DeadlineError: the model took too long.
            ModelError: it gave no answer, or twice one that is none.
        """
        workers = min(self._talker.at_once, len(phrases))
        if workers == 1:
            return [self._ask(context, phrase) for phrase in phrases]
        with ThreadPoolExecutor(workers, thread_name_prefix="pointer") as pool:
            return list(pool.map(lambda phrase: self._ask(context, phrase), phrases))

    def warm_up(self) -> None:
        """Let a model in this process answer once; ask nothing of one elsewhere."""
        self._talker.warm_up()

    def close(self) -> None:
        """Let go of the model. Idempotent."""
        self._talker.close()

    def _ask(self, context: PointerContext, phrase: str) -> Evidence:
        reading = self._places(context.shown, fill(self._question, phrase))
        shown = context.shown
        frame = Frame(context.width, context.height, shown.width, shown.height)
        evidence, outside = evidence_of(
            reading.places, self._options.units, frame, self._options.reach
        )
        if outside or reading.dropped:
            _LOG.warning(
                "places of an answer dropped",
                extra={"phrase": phrase, "outside": outside, "too_many": reading.dropped},
            )
        return evidence

    def _places(self, shown: Shown, question: str) -> Reading:
        """Return what the model names; an answer that names nothing is shown to it once."""
        turns = [Turn("user", question)]
        answer = self._talker.ask(shown, turns)
        try:
            return read_answer(answer, self._options.format)
        except ModelError:
            turns += [Turn("assistant", answer[:1000]), Turn("user", AGAIN)]
        return read_answer(self._talker.ask(shown, turns), self._options.format)
