"""Things of one kind from several pictures: each phrase is asked of all of them.

A picture seldom holds two of a kind that one attribute tells apart. A step that shows books of four
pictures holds many such pairs: "the leather book" is to be told from the paper ones of the others.
"""

from collections import defaultdict
from collections.abc import Iterable

import numpy as np

from w2c_grounding.second_look.network import ARTICLES
from w2c_grounding.train.asker import FURNITURE, Question, framed
from w2c_grounding.train.data import ObjectTruth, PictureTruth
from w2c_grounding.train.phrases import PhraseKind, could_fit, fitting, kind_of
from w2c_grounding.train.second_look.squares import Squares
from w2c_grounding.train.uses import is_use
from w2c_grounding.wording import words

TOLD_BY: tuple[tuple[PhraseKind, float], ...] = (("material", 0.65), ("colour", 0.35))
"""What a thing is told from others of its kind by, and how often"""


class Kinds:
    """Knows which pictures hold which kinds, and what fits things of other pictures."""

    def __init__(self, squares: Squares) -> None:
        self._squares = squares
        pictures: dict[str, list[int]] = defaultdict(list)
        for number, truth in enumerate(squares.truths):
            for kind in sorted({item.kind for item in truth.clearly_visible()} - FURNITURE):
                pictures[kind].append(number)
        # One picture of a kind has nothing to be compared with.
        self._pictures = {kind: numbers for kind, numbers in pictures.items() if len(numbers) > 1}
        self._kinds = sorted(self._pictures)
        counts = np.array([len(self._pictures[kind]) for kind in self._kinds], dtype=float)
        # Rare kinds come more often than by their number, common ones less.
        self._shares = np.sqrt(counts) / max(float(np.sqrt(counts).sum()), 1.0)

    def draw(self, groups: int, size: int, rng: np.random.Generator) -> list[tuple[int, str]]:
        """Return pictures (number, kind that it was chosen for): up to `size` of some kinds."""
        groups = min(groups, len(self._kinds))
        if groups == 0:
            return []
        drawn = []
        for kind in rng.choice(len(self._kinds), groups, replace=False, p=self._shares).tolist():
            having = self._pictures[self._kinds[kind]]
            some = rng.choice(len(having), min(size, len(having)), replace=False).tolist()
            drawn += [(having[number], self._kinds[kind]) for number in some]
        return drawn

    def questions(
        self, truth: PictureTruth, kind: str, count: int, rng: np.random.Generator
    ) -> list[Question]:
        """Return phrases that tell the things of a kind from others of that kind."""
        things = [item for item in truth.clearly_visible() if item.kind == kind]
        found: list[Question] = []
        for _ in range(count if things else 0):
            item = things[int(rng.integers(len(things)))]
            wanted = TOLD_BY[int(rng.choice(len(TOLD_BY), p=[share for _, share in TOLD_BY]))][0]
            texts = [text for text in item.phrases if kind_of(item, text) == wanted]
            if texts:
                text = texts[int(rng.integers(len(texts)))]
                found.append(Question(framed(text, rng), fitting(truth, text)))
        return found

    def elsewhere(
        self, phrase: str, meant: Iterable[ObjectTruth], others: Iterable[int]
    ) -> list[tuple[int, bool]]:
        """Return which squares of other pictures a phrase fits (number, whether it does).

        Args:
            phrase: Of a picture.
            meant: The things that it means there: squares of other kinds are left out.
            others: Numbers of squares.
        """
        kinds = {item.kind for item in meant} - FURNITURE
        bare = _bare(phrase)
        if not kinds or is_use(bare):
            return []  # a use says no more than the kind
        spoken = set(words(bare))
        answers = []
        for number in others:
            item = self._squares.cuts[number].item
            if item is None or item.kind not in kinds:
                continue
            alone = _alone(item)
            if fitting(alone, bare):
                answers.append((number, True))
            elif not could_fit(alone, bare) and spoken.isdisjoint(item.looks_like):
                answers.append((number, False))
        return answers


def _bare(phrase: str) -> str:
    first, _, rest = phrase.partition(" ")
    return rest if rest and first in ARTICLES else phrase


def _alone(item: ObjectTruth) -> PictureTruth:
    """Return the truth of a picture of nothing else."""
    return PictureTruth("", "", 1, 1, 0, (item,))
