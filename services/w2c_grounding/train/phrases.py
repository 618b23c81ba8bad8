"""What to ask about a picture: phrases that fit objects in it, and phrases that fit none."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from w2c_grounding.train.data import SIZES, ObjectTruth, PictureTruth
from w2c_grounding.train.uses import EVERY_USE, fitting_kinds, is_use, possible_kinds, uses_of
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
# Kinds that are kept for judging are not among them.
FOREIGN = (
    "chair", "door", "person", "dog", "cat", "phone", "screen", "monitor", "pillow", "sofa",
    "glove", "knife", "fork", "spoon", "kettle", "oven", "sink", "vase", "clock", "mirror",
    "curtain", "bag", "backpack", "wallet", "key", "pen", "scissors", "ruler", "orange juice",
    "cheese", "egg", "carrot", "guitar", "piano", "car", "bicycle", "tree", "elephant", "saw",
    "broom", "ladder", "rope", "candle", "camera", "radio", "speaker", "remote control",
    "umbrella", "toothbrush", "drawer", "handrail", "socket", "toaster", "vacuum cleaner", "tablet",
    "bed", "carpet", "bench", "violin", "skateboard", "balloon", "suitcase", "tent", "drum",
)  # fmt: skip


@dataclass(frozen=True)
class Question:
    """A phrase and the objects it fits; none = the answer is that nothing fits."""

    phrase: str
    identities: tuple[int, ...]


PhraseKind = Literal["name", "synonym", "colour", "material", "size", "part", "any", "use", "pair"]
"""How a phrase says which thing it means; `any` names no kind, as `the red thing` does, `use` says
what it is for, and `pair` tells one of two of a kind from the other by any of the attributes"""

SHARES: dict[PhraseKind, float] = {
    "name": 0.24, "synonym": 0.14, "colour": 0.14, "material": 0.10, "size": 0.06, "part": 0.06,
    "any": 0.06, "use": 0.12, "pair": 0.12,
}  # fmt: skip
"""How often each is asked in training, where it can be"""
PART_START = "thing with the "
NOUNS_OF_ANYTHING = ("thing", "object", "one")
FURNITURE_WEIGHT = 0.3
"""Table, counter or shelf is in nearly every picture: asked for less often than other things"""
FURNITURE = frozenset({"table", "counter", "shelf"})


COLOUR_WORDS = frozenset(
    {"red", "orange", "yellow", "green", "blue", "purple", "pink", "brown", "black", "grey"}
    | {"white", "turquoise"}
)


def fitting(truth: PictureTruth, phrase: str) -> tuple[int, ...]:
    """Return the ids of the objects that a bare phrase fits."""
    if is_use(phrase):
        kinds = fitting_kinds(phrase)
        return tuple(item.id for item in truth.objects if item.kind in kinds)
    spoken = words(phrase)
    if spoken[-1] in NOUNS_OF_ANYTHING and len(spoken) > 1:
        return tuple(
            item.id
            for item in truth.objects
            if all(word == item.colour or word in material_words(item) for word in spoken[:-1])
        )
    return tuple(item.id for item in truth.objects if phrase in item.phrases)


def kind_of(item: ObjectTruth, phrase: str) -> PhraseKind:
    """Return how a phrase of an object's own names it; never `any` or `pair`."""
    if phrase in item.names:
        return "name" if phrase == item.names[0] else "synonym"
    if phrase.startswith(PART_START):
        return "part"
    if phrase.startswith(SIZES):
        return "size"
    name = max((name for name in item.names if phrase.endswith(f" {name}")), key=len, default="")
    before = set(phrase.removesuffix(name).split())
    return "material" if before - {item.colour} else "colour"


def material_words(item: ObjectTruth) -> frozenset[str]:
    """Return what is said before its name for what it is made of: wood and wooden."""
    usual = f" {item.names[0]}"
    found = {
        phrase.removesuffix(usual)
        for phrase in item.phrases
        if phrase.endswith(usual) and phrase not in item.names
    }
    plain = {word for word in found if " " not in word}
    sizes = {size.strip() for size in SIZES}
    return frozenset(plain - sizes - COLOUR_WORDS - {item.colour}) if item.material else frozenset()


def phrases_by_kind(truth: PictureTruth, item: ObjectTruth) -> dict[PhraseKind, list[str]]:
    """Return all that can be said of an object in its picture."""
    found: dict[PhraseKind, list[str]] = defaultdict(list)
    for phrase in item.phrases:
        found[kind_of(item, phrase)].append(phrase)
    if any(other.kind == item.kind and other.id != item.id for other in truth.objects):
        attributes: tuple[PhraseKind, ...] = ("colour", "material", "size", "part")
        telling = [text for kind in attributes for text in found.get(kind, ())]
        own = [text for text in telling if fitting(truth, text) == (item.id,)]
        if own:
            found["pair"] = own
    # Where a neighbouring colour is in the picture, people would not agree.
    if not any(_close(item.colour, o.colour) and item.colour != o.colour for o in truth.objects):
        found["any"].append(f"{item.colour} thing")
    found["any"] += [f"{word} thing" for word in sorted(material_words(item))]
    found["use"] = [text for text in uses_of(item.kind) if _is_clear(truth, text)]
    return {kind: texts for kind, texts in found.items() if texts}


def _is_clear(truth: PictureTruth, use: str) -> bool:
    """Tell whether nothing in the picture only might be meant by a phrase of use."""
    doubtful = possible_kinds(use) - fitting_kinds(use)
    return not any(item.kind in doubtful for item in truth.objects)


def could_fit(truth: PictureTruth, phrase: str) -> bool:
    """Tell whether somebody could call an object in the picture this.

    Then it is no negative example. The head noun decides: a cereal box is a box too.
    """
    if is_use(phrase):
        kinds = possible_kinds(phrase)
        return any(item.kind in kinds for item in truth.objects)
    spoken = words(phrase)
    if phrase.startswith(PART_START):
        return any(_could_have_part(item, phrase) for item in truth.objects)
    head = spoken[-1]
    return any(
        _could_be(item, spoken[:-1])
        for item in truth.objects
        if head in NOUNS_OF_ANYTHING
        or any(words(name)[-1] == head or name == head for name in item.names)
    )


def _could_be(item: ObjectTruth, attributes: Sequence[str]) -> bool:
    """Tell whether nothing that is said of colour and material speaks against it."""
    colours = {word for word in attributes if word in COLOUR_WORDS}
    materials = {word for word in attributes if word in _KNOWN_MATERIALS}
    if colours and not any(_close(colour, item.colour) for colour in colours):
        return False
    return not materials or bool(materials & material_words(item)) or not item.material


def _could_have_part(item: ObjectTruth, phrase: str) -> bool:
    """Tell whether it has this part, of this material or of one that nobody said."""
    part = phrase.rsplit(" ", 1)[-1]
    if phrase in item.phrases:
        return True
    said = any(text.startswith(PART_START) and text.endswith(f" {part}") for text in item.phrases)
    return not said and any(other.name.endswith(part) for other in item.parts)


def _close(first: str, second: str) -> bool:
    return first == second or frozenset((first, second)) in _CLOSE_COLOURS


_KNOWN_MATERIALS = frozenset(
    {"wood", "wooden", "metal", "plastic", "ceramic", "glass", "stone", "cardboard", "paper"}
    | {"leather", "cotton", "wool", "woollen", "rubber", "wicker", "fabric"}
)


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
        phrase = _one(offers[kind], rng)
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
        words_of_material = self._materials if rng.random() < 0.35 else ()
        return _one(words_of_material or self._colours, rng)


def _choose(
    clear: Sequence[ObjectTruth], count: int, rng: np.random.Generator
) -> list[ObjectTruth]:
    """Return objects to ask for, each once where there are enough of them."""
    if not clear:
        return []
    weights = np.array([FURNITURE_WEIGHT if item.kind in FURNITURE else 1.0 for item in clear])
    weights /= weights.sum()
    chosen: list[int] = []
    while len(chosen) < count:
        some = min(count - len(chosen), len(clear))
        chosen += [int(i) for i in rng.choice(len(clear), size=some, replace=False, p=weights)]
    return [clear[index] for index in chosen]


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
