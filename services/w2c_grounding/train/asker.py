"""Draws questions about a picture: phrases that fit objects in it, and phrases that fit none."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from w2c_grounding.train.data import ObjectTruth, PictureTruth
from w2c_grounding.train.phrases import (
    COLOUR_WORDS,
    NOUNS_OF_ANYTHING,
    PART_START,
    PhraseKind,
    could_fit,
    fitting,
    kind_of,
    material_words,
    phrases_by_kind,
)
from w2c_grounding.train.uses import EVERY_USE

FRAMES = ("{}", "{}", "{}", "the {}", "the {}", "a {}", "my {}", "that {}")
"""Ways to say a phrase; most often it comes bare, as the dialogue's analyzer extracts it."""

# Things that no scene holds: what the model must learn to have never seen. Not in the vocabulary,
# also where phrases of use have them: a flame that means a pan would be vetoed.
# Kinds that are kept for judging are not among them.
FOREIGN = (
    "chair", "door", "person", "dog", "cat", "phone", "screen", "monitor", "pillow", "sofa",
    "glove", "knife", "fork", "spoon", "kettle", "oven", "sink", "vase", "clock", "mirror",
    "curtain", "bag", "backpack", "wallet", "key", "pen", "scissors", "ruler", "orange juice",
    "cheese", "egg", "carrot", "guitar", "piano", "car", "bicycle", "tree", "elephant", "saw",
    "broom", "ladder", "rope", "candle", "camera", "radio", "speaker", "remote control",
    "umbrella", "toothbrush", "drawer", "handrail", "socket", "toaster", "vacuum cleaner", "tablet",
    "bed", "carpet", "bench", "violin", "skateboard", "balloon", "suitcase", "tent", "drum",
    "flame", "face", "child",
)  # fmt: skip

SHARES: dict[PhraseKind, float] = {
    "name": 0.14, "synonym": 0.10, "colour": 0.07, "material": 0.12, "size": 0.04, "part": 0.05,
    "any": 0.06, "use": 0.20, "pair": 0.22,
}  # fmt: skip
"""How often each is asked in training, where it can be"""
FURNITURE_WEIGHT = 0.3
"""Table, counter or shelf is in nearly every picture: asked for less often than other things"""
FURNITURE = frozenset({"table", "counter", "shelf"})
PAIR_WEIGHT = 2.0
"""One of two of a kind is asked for more often: which of them is meant is what is hardest"""


@dataclass(frozen=True)
class Question:
    """A phrase and the objects it fits; none = the answer is that nothing fits."""

    phrase: str
    identities: tuple[int, ...]


class Asker:
    """Draws questions about pictures."""

    def __init__(self, truths: Sequence[PictureTruth]) -> None:
        names: dict[str, None] = {}
        parts: set[str] = set()
        materials: set[str] = set()
        for truth in truths:
            for item in truth.objects:
                names.update(dict.fromkeys(item.names))
                parts.update(text for text in item.phrases if text.startswith(PART_START))
                materials |= material_words(item)
        self.names = tuple(sorted(names))
        self._parts = tuple(sorted(parts))
        self._materials = tuple(sorted(materials))
        self._colours = tuple(sorted(COLOUR_WORDS))

    def ask(
        self,
        truth: PictureTruth,
        clear: Sequence[ObjectTruth],
        present: int,
        absent: int,
        rng: np.random.Generator,
    ) -> list[Question]:
        """Return `present + absent` questions; more absent ones where nothing is clear.

        Args:
            truth: Of the picture, or of the part of it that is shown.
            clear: Objects that may be asked for.
            present: Phrases that fit something.
            absent: Phrases that fit nothing.
            rng: Source of chance.
        """
        questions = [self._about(truth, item, rng) for item in _choose(clear, present, rng)]
        while len(questions) < present + absent:
            questions.append(Question(self.absent(truth, rng), ()))
        return questions

    def absent(self, truth: PictureTruth, rng: np.random.Generator) -> str:
        """Return a phrase that fits nothing in the picture."""
        while True:
            phrase = self._candidate(truth, rng)
            if not could_fit(truth, phrase):
                return framed(phrase, rng)

    def _about(self, truth: PictureTruth, item: ObjectTruth, rng: np.random.Generator) -> Question:
        offers = phrases_by_kind(truth, item)
        kinds = sorted(offers)
        shares = np.array([SHARES[kind] for kind in kinds])
        kind = kinds[int(rng.choice(len(kinds), p=shares / shares.sum()))]
        texts = offers[kind]
        if kind == "pair":
            # What can be said of colour outnumbers the rest, and is the easiest to learn.
            attribute = _one(sorted({kind_of(item, text) for text in texts}), rng)
            texts = [text for text in texts if kind_of(item, text) == attribute]
        phrase = _one(texts, rng)
        identities = fitting(truth, phrase)
        if kind == "any":
            phrase = phrase.replace("thing", _one(NOUNS_OF_ANYTHING, rng))
        return Question(framed(phrase, rng), identities)

    def _candidate(self, truth: PictureTruth, rng: np.random.Generator) -> str:
        """Return a phrase that may fit nothing: often of a thing that is there, but otherwise."""
        chance = rng.random()
        if chance < 0.15:
            return self._strange(rng)
        if chance < 0.50:
            return _one(self.names, rng)
        if chance < 0.80 and truth.objects:
            item = truth.objects[int(rng.integers(len(truth.objects)))]
            return f"{self._attribute(rng)} {_one(item.names, rng)}"
        if chance < 0.84 and self._parts:
            return _one(self._parts, rng)
        if chance < 0.88:
            return _one(EVERY_USE, rng)
        nouns = self.names if chance < 0.95 else NOUNS_OF_ANYTHING
        return f"{self._attribute(rng)} {_one(nouns, rng)}"

    def _strange(self, rng: np.random.Generator) -> str:
        """Return a noun that no scene has, or one that no language has."""
        if rng.random() < 0.3:
            return invented_word(rng)
        noun = _one(FOREIGN, rng)
        return f"{self._attribute(rng)} {noun}" if rng.random() < 0.3 else noun

    def _attribute(self, rng: np.random.Generator) -> str:
        words_of_material = self._materials if rng.random() < 0.5 else ()
        return _one(words_of_material or self._colours, rng)


def _choose(
    clear: Sequence[ObjectTruth], count: int, rng: np.random.Generator
) -> list[ObjectTruth]:
    """Return objects to ask for, each once where there are enough of them."""
    if not clear:
        return []
    numbers = Counter(item.kind for item in clear)
    weights = np.array([_weight(item, numbers[item.kind]) for item in clear])
    weights /= weights.sum()
    chosen: list[int] = []
    while len(chosen) < count:
        some = min(count - len(chosen), len(clear))
        chosen += [int(i) for i in rng.choice(len(clear), size=some, replace=False, p=weights)]
    return [clear[index] for index in chosen]


def _weight(item: ObjectTruth, of_its_kind: int) -> float:
    if item.kind in FURNITURE:
        return FURNITURE_WEIGHT
    return PAIR_WEIGHT if of_its_kind > 1 else 1.0


def _one(values: Sequence[str], rng: np.random.Generator) -> str:
    return values[int(rng.integers(len(values)))]


_SYLLABLE = (list("bcdfghjklmnprstvwz"), list("aeiou"), ["", "n", "r", "s", "t"])


def invented_word(rng: np.random.Generator) -> str:
    """Return a word that means nothing, so that unknown spellings come to mean "not here"."""
    syllables = [
        "".join(str(rng.choice(letters)) for letters in _SYLLABLE)
        for _ in range(int(rng.integers(2, 4)))
    ]
    return "".join(syllables)


def framed(phrase: str, rng: np.random.Generator) -> str:
    """Return a phrase as somebody may say it."""
    return _one(FRAMES, rng).replace("{}", phrase)
