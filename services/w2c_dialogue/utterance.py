"""What the operator typed, as words that a model can point at.

A small model copies numbers well and rare words badly, so it names an object by the numbers of its
words ("5-6"), and the words themselves are taken from here. Everything a model sees of an
utterance goes through `Utterance`: it bounds the length and drops what could pose as part of a
prompt.
"""

import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from w2c.errors import ModelError, RefusedError

MAX_WORDS = 60
MAX_CHARACTERS = 500
LETTERS = "abc"
"""Names of objects in order of mention; no instruction needs more than three."""

LONGEST_WITH_HEAD = 3
"""Words of a phrase whose last one is its noun, most likely; longer ones end in a description"""

_POINTING = frozenset({"the", "that", "this", "your", "my"})
_NO_HEADS = frozenset({"left", "right", "one", "top", "bottom", "front", "back", "side", "it"})
"""Words behind an article that need not mean the phrase that ends in them"""
_OUTER = '.!?;:"()[]{}<>`*_~|\\/'
_POSSESSIVE = ("'s", "'S", "\u2019s", "\u2019S")
_QUOTES = str.maketrans({"\u2019": "'", "\u2018": "'", "\u201c": '"', "\u201d": '"', "`": "'"})


class Span(tuple[int, int]):
    """First and last word of a phrase, counted from 1, both inside."""

    __slots__ = ()

    def __new__(cls, first: int, last: int) -> "Span":
        """Name the words `first` to `last`."""
        return super().__new__(cls, (first, last))

    def __str__(self) -> str:
        """Return the form that models read and write: `5-6`."""
        return f"{self[0]}-{self[1]}"


@dataclass(frozen=True)
class Mention:
    """An object that an utterance names."""

    phrase: str
    """What to look for"""
    span: Span | None
    """Its words; None where a model paraphrased"""


@dataclass(frozen=True)
class Utterance:
    """An utterance cut into words. Build it with `parse`."""

    typed: tuple[str, ...]
    """The words as typed, quotes straightened."""
    folded: tuple[str, ...]
    """The same words in lower case, without outer punctuation, commas kept."""
    raw: tuple[str, ...]
    """The same words with the very quotes and accents of the keyboard."""

    @property
    def text(self) -> str:
        """The utterance as typed, on one line."""
        return " ".join(self.typed)

    @property
    def folded_text(self) -> str:
        """The utterance as a small model reads it."""
        return " ".join(self.folded).rstrip(",")

    def numbered(self) -> str:
        """Return the folded words, each with its number behind it: `lean1 103.2 on3 it4`.

        Behind, because a model reads forwards: it finds the word and copies what follows.
        """
        return " ".join(
            f"{word}.{i}" if word[-1].isdigit() else f"{word}{i}"
            for i, word in enumerate(self.folded, 1)
        )

    def phrase(self, span: Span) -> str:
        """Return the words of a span as typed, without outer punctuation and possessive s.

        Raises:
            ModelError: the utterance has no such words.
        """
        return _cut(self.typed, span)

    def verbatim(self, span: Span) -> str:
        """Return the same, exactly as it was typed. Raises as `phrase` does."""
        return _cut(self.raw, span)

    def with_letters(self, spans: Sequence[Span | None]) -> str:
        """Return the folded text with each phrase replaced by its capital letter: `left of the A`.

        What is named again gets the same letter: `between the A and the B, nearer to the B`. The
        text is in lower case, so a capital letter cannot be a word of the operator.
        """
        words: list[str] = []
        starts = repetitions(self.folded, spans) | {
            span[0]: (letter.upper(), span[1])
            for letter, span in zip(LETTERS, spans, strict=False)
            if span is not None
        }
        index = 1
        while index <= len(self.folded):
            if index in starts:
                letter, index = starts[index]
                last = self.folded[index - 1]
                possessive = "'s" if last.rstrip(",").endswith("'s") else ""
                words.append(letter + possessive + "," * last.endswith(","))
            else:
                words.append(self.folded[index - 1])
            index += 1
        return " ".join(words).rstrip(",")


def repetitions(folded: Sequence[str], spans: Sequence[Span | None]) -> dict[int, tuple[str, int]]:
    """Return where phrases are named again, behind all of them.

    By all their words, or by the last one behind an article: `the yellow bin ... nearer the bin`.

    Args:
        folded: The words of an utterance.
        spans: Of the phrases, in order of their letters.

    Returns:
        The first word of each repetition, counted from 1, with its letter and its last word.
    """
    names = {
        letter.upper(): _bare(folded[span[0] - 1 : span[1]])
        for letter, span in zip(LETTERS, spans, strict=False)
        if span is not None
    }
    heads = [name[-1] for name in names.values()]
    found: dict[int, tuple[str, int]] = {}
    at = max((span[1] for span in spans if span is not None), default=len(folded))
    while at < len(folded):
        letter, length = _name_at(_bare(folded[at:]), names, heads, folded[at - 1])
        if letter:
            found[at + 1] = letter, at + length
        at += length
    return found


def _name_at(
    words: Sequence[str], names: Mapping[str, Sequence[str]], heads: Sequence[str], before: str
) -> tuple[str, int]:
    """Return the letter that the first of these words name, and how many; ("", 1) for none."""
    for letter, name in names.items():
        if words[: len(name)] == name:
            return letter, len(name)
    for letter, name in names.items():
        is_head = words[0] == name[-1] and before in _POINTING and words[0] not in _NO_HEADS
        if is_head and heads.count(words[0]) == 1 and len(name) <= LONGEST_WITH_HEAD:
            return letter, 1
    return "", 1


def _bare(words: Sequence[str]) -> list[str]:
    return [word.rstrip(",").removesuffix("'s") for word in words]


def parse(text: str) -> Utterance:
    """Cut text into words.

    Raises:
        RefusedError: nothing is left of it, or it is too long.
    """
    if len(text) > MAX_CHARACTERS:
        raise RefusedError(
            f"That is {len(text)} characters long; please use {MAX_CHARACTERS} at most."
        )
    raw = "".join(map(_plain, text)).split()
    typed = [unicodedata.normalize("NFC", word).translate(_QUOTES) for word in raw]
    words = [(word, fold(word), as_is) for word, as_is in zip(typed, raw, strict=True)]
    words = [entry for entry in words if entry[1].strip(",")]
    if not words:
        raise RefusedError(
            "I heard no words. Tell me where to put a hand, for example: lean on the table."
        )
    if len(words) > MAX_WORDS:
        raise RefusedError(f"That is {len(words)} words long; please use {MAX_WORDS} at most.")
    return Utterance(*(tuple(entry[form] for entry in words) for form in range(3)))


def fold(word: str) -> str:
    """Return a word in lower case without outer punctuation; a comma at its end stays."""
    inner = word.strip(_OUTER + "'" + ",").lower()
    return inner + "," if inner and word.rstrip(_OUTER).endswith(",") else inner


def _cut(words: Sequence[str], span: Span) -> str:
    """Return the words of a span without outer punctuation and possessive s."""
    first, last = span
    if not 1 <= first <= last <= len(words):
        raise ModelError(f"words {span} are not in an utterance of {len(words)} words")
    phrase = " ".join(words[first - 1 : last]).strip(_OUTER + ", '\u2018\u2019\u201c\u201d")
    ending = next((ending for ending in _POSSESSIVE if phrase.endswith(ending)), "")
    return phrase.removesuffix(ending)


def _plain(character: str) -> str:
    """Return the character, or a space for one that is no text (control, format, private use)."""
    return " " if unicodedata.category(character).startswith("C") else character
