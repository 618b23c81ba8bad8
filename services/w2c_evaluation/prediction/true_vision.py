"""Eyes that know the answer: the boxes and areas of the folder itself, for `truth`.

With them only words can be misunderstood, so they tell what the language model makes of a prompt,
and how many prompts the usual arithmetic answers at all. Results name them.
"""

from collections.abc import Sequence

import cv2
import numpy as np

from w2c.errors import ConfigError
from w2c.messages import Box, PhraseEvidence
from w2c_evaluation.benchmark.dataset import Item
from w2c_evaluation.benchmark.record import NamedThing
from w2c_evaluation.prediction.judging import plain

NAME = "truth"


class TrueVision:
    """In the place of a vision model."""

    def __init__(self, items: Sequence[Item]) -> None:
        """Take the items. Raises ConfigError for a folder that does not know its things."""
        unknown = [item.record.id for item in items if item.record.things is None]
        if unknown:
            raise ConfigError(
                f"'{NAME}' as a vision model: {unknown[0]} and {len(unknown) - 1} more have no "
                "`things`; only a folder that says where its things are can stand in"
            )
        self.item = items[0]
        """That is asked about from now on: two prompts may share a picture"""
        self.name = NAME

    def ground(self, picture: bytes, phrases: Sequence[str], want: str) -> list[PhraseEvidence]:
        """Return the true box of each phrase that the prompt names; the point is accepted."""
        del picture, want
        known = self.item.record.things or ()
        things = {plain(thing.words): thing for thing in known}
        return [self._evidence(self.item, phrase, things.get(plain(phrase))) for phrase in phrases]

    @staticmethod
    def _evidence(item: Item, phrase: str, thing: NamedThing | None) -> PhraseEvidence:
        if thing is None:
            return PhraseEvidence(phrase=phrase, found=False, score=0.0, point=None, boxes=[])
        left, top, right, bottom = thing.box
        box = Box(left=left, top=top, right=right, bottom=bottom, score=1.0)
        return PhraseEvidence(phrase=phrase, found=True, score=1.0, point=inner(item), boxes=[box])


def inner(item: Item) -> tuple[float, float]:
    """Return the accepted pixel (u, v) that is farthest from the edge of the area."""
    padded = np.pad(item.accepted().astype(np.uint8), 1)
    distance = cv2.distanceTransform(padded, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)[1:-1, 1:-1]
    row, column = np.unravel_index(int(np.argmax(distance)), distance.shape)
    return float(column) + 0.5, float(row) + 0.5
