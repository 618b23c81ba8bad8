"""Which words a model knows, and which of them are one token."""

from collections.abc import Iterable, Sequence

from w2c_grounding.sizes import has_size
from w2c_grounding.train.asker import FOREIGN, FRAMES
from w2c_grounding.train.data import PictureTruth
from w2c_grounding.train.phrases import COLOUR_WORDS, NOUNS_OF_ANYTHING
from w2c_grounding.train.uses import uses_of
from w2c_grounding.wording import words


def vocabulary_of(truths: Iterable[PictureTruth]) -> list[str]:
    """Return the words that named something in a picture, in alphabetical order.

    The dog of "thing a dog fetches" is in none: it stays a word that the model does not know.
    """
    items = [item for truth in truths for item in truth.objects]
    named = {word for item in items for text in item.phrases for word in words(text)}
    uses = {text for kind in {item.kind for item in items} for text in uses_of(kind)}
    foreign = {word for noun in FOREIGN for word in words(noun)}
    said = {word for text in uses for word in words(text)} - foreign
    return sorted(named.union(said, NOUNS_OF_ANYTHING)) if named else []


def names_of_size(truths: Iterable[PictureTruth]) -> set[str]:
    """Return the names of things of pictures that have a word of size in them."""
    names = {name for truth in truths for item in truth.objects for name in item.names}
    return {name for name in names if has_size(name)}


def tokenizer_words(vocabulary: Sequence[str]) -> list[str]:
    """Return the words that shall be one token each: the vocabulary and the words of the frames."""
    framing = (word for frame in FRAMES for word in words(frame))
    return sorted({*vocabulary, *framing, *COLOUR_WORDS, *NOUNS_OF_ANYTHING})
