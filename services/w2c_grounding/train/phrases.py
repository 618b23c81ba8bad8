"""What to ask about a picture: phrases that fit objects in it, and phrases that fit none."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from w2c_grounding.train.data import ObjectTruth, PictureTruth
from w2c_grounding.wording import words

FRAMES = ("{}", "{}", "{}", "the {}", "the {}", "a {}", "my {}", "that {}")
"""Ways to say a phrase; most often it comes bare, as the dialogue's analyzer extracts it."""

# Colours that people draw different borders between: a "red" book is not asked to be no "orange"
# one.
_CLOSE_COLOURS = frozenset(
    frozenset(pair)
    for pair in (
        ("red", "orange"), ("red", "pink"), ("red", "brown"), ("orange", "yellow"),
        ("orange", "brown"), ("blue", "turquoise"), ("green", "turquoise"), ("blue", "purple"),
        ("purple", "pink"), ("black", "grey"), ("grey", "white"), ("black", "brown"),
    )
)  # fmt: skip

# Things that no scene holds: what the model must learn to have never seen. Not in the vocabulary.
FOREIGN = (
    "chair", "lamp", "window", "door", "person", "dog", "cat", "phone", "laptop", "keyboard",
    "screen", "monitor", "pillow", "sofa", "shoe", "hat", "glove", "knife", "fork", "spoon",
    "pan", "pot", "kettle", "stove", "oven", "fridge", "sink", "flower", "plant", "vase",
    "clock", "picture", "mirror", "curtain", "bag", "backpack", "wallet", "key", "pen", "pencil",
    "scissors", "ruler", "banana", "orange juice", "bread", "cheese", "egg", "carrot", "guitar",
    "piano", "car", "bicycle", "tree", "elephant", "helmet", "drill", "saw", "screwdriver",
    "wrench", "bucket", "broom", "ladder", "rope", "candle", "camera", "radio", "speaker",
    "remote control", "umbrella", "toothbrush", "soap", "shelf", "drawer", "handrail", "socket",
)  # fmt: skip


@dataclass(frozen=True)
class Question:
    """A phrase and the objects it fits; none = the answer is that nothing fits."""

    phrase: str
    identities: tuple[int, ...]


def fitting(truth: PictureTruth, phrase: str) -> tuple[int, ...]:
    """Return the ids of the objects that a bare phrase fits."""
    return tuple(item.id for item in truth.objects if phrase in item.phrases)


def could_fit(truth: PictureTruth, phrase: str) -> bool:
    """Tell whether somebody could call an object in the picture this.

    Then it is no negative example. The head noun decides: a cereal box is a box too.
    """
    spoken = words(phrase)
    head = spoken[-1]
    for item in truth.objects:
        if any(words(name)[-1] == head or name == head for name in item.names):
            colours = {word for word in spoken if word in COLOUR_WORDS}
            if not colours or any(_close(colour, item.colour) for colour in colours):
                return True
    return False


def _close(first: str, second: str) -> bool:
    return first == second or frozenset((first, second)) in _CLOSE_COLOURS


COLOUR_WORDS = frozenset(
    {"red", "orange", "yellow", "green", "blue", "purple", "pink", "brown", "black", "grey"}
    | {"white", "turquoise"}
)


class Asker:
    """Draws questions about pictures."""

    def __init__(self, truths: Sequence[PictureTruth], favourites: frozenset[str]) -> None:
        """`favourites` are kinds that are asked for more often: those of the scenarios."""
        self._favourites = favourites
        names: dict[str, None] = {}
        for truth in truths:
            for item in truth.objects:
                names.update(dict.fromkeys(item.names))
        self.names = tuple(sorted(names))

    def ask(
        self, truth: PictureTruth, present: int, absent: int, rng: np.random.Generator
    ) -> list[Question]:
        """Return `present + absent` questions; more absent ones where little is to be seen."""
        questions = [self._about(truth, item, rng) for item in self._choose(truth, present, rng)]
        while len(questions) < present + absent:
            questions.append(Question(self.absent(truth, rng), ()))
        return questions

    def absent(self, truth: PictureTruth, rng: np.random.Generator) -> str:
        """Return a phrase that fits nothing in the picture."""
        while True:
            phrase = self._candidate(truth, rng)
            if not could_fit(truth, phrase):
                return _framed(phrase, rng)

    def _choose(
        self, truth: PictureTruth, count: int, rng: np.random.Generator
    ) -> list[ObjectTruth]:
        visible = truth.clearly_visible()
        if not visible:
            return []
        weights = np.array([5.0 if item.kind in self._favourites else 1.0 for item in visible])
        count = min(count, len(visible))
        chosen = rng.choice(len(visible), size=count, replace=False, p=weights / weights.sum())
        return [visible[int(index)] for index in chosen]

    def _about(self, truth: PictureTruth, item: ObjectTruth, rng: np.random.Generator) -> Question:
        # Mostly bare names: what a thing is takes far longer to learn than what colour it has.
        pool = item.names if rng.random() < 0.7 else item.phrases
        phrase = str(rng.choice(pool))
        return Question(_framed(phrase, rng), fitting(truth, phrase))

    def _candidate(self, truth: PictureTruth, rng: np.random.Generator) -> str:
        chance = rng.random()
        if chance < 0.45:
            name = str(rng.choice(self.names))
            return f"{rng.choice(sorted(COLOUR_WORDS))} {name}" if rng.random() < 0.3 else name
        if chance < 0.7 and truth.objects:
            item = truth.objects[int(rng.integers(len(truth.objects)))]
            return f"{rng.choice(sorted(COLOUR_WORDS))} {rng.choice(item.names)}"
        if chance < 0.9:
            noun = str(rng.choice(FOREIGN))
            return f"{rng.choice(sorted(COLOUR_WORDS))} {noun}" if rng.random() < 0.3 else noun
        return invented_word(rng)


_SYLLABLE = (list("bcdfghjklmnprstvwz"), list("aeiou"), ["", "n", "r", "s", "t"])


def invented_word(rng: np.random.Generator) -> str:
    """Return a word that means nothing, so that unknown spellings come to mean "not here"."""
    syllables = [
        "".join(str(rng.choice(letters)) for letters in _SYLLABLE)
        for _ in range(int(rng.integers(2, 4)))
    ]
    return "".join(syllables)


def vocabulary_of(truths: Sequence[PictureTruth]) -> list[str]:
    """Return the words that named something in a picture, in alphabetical order."""
    return sorted(
        {
            word
            for truth in truths
            for item in truth.objects
            for phrase in item.phrases
            for word in words(phrase)
        }
    )


def tokenizer_words(vocabulary: Sequence[str]) -> list[str]:
    """Return the words that shall be one token each: the vocabulary and the words of the frames."""
    framing = (word for frame in FRAMES for word in words(frame))
    return sorted({*vocabulary, *framing, *COLOUR_WORDS})


def _framed(phrase: str, rng: np.random.Generator) -> str:
    return str(rng.choice(FRAMES)).replace("{}", phrase)
