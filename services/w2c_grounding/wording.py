"""Words of phrases: what is sent to a model, and which words it never saw."""

import re
import unicodedata
from collections.abc import Iterable

from w2c.errors import ConfigError, RefusedError

_WORD = re.compile(r"[^\W_]+(?:['-][^\W_]+)*")
_ARTICLE = re.compile(r"^(?:an?|the)\s+", re.IGNORECASE)
_ARTICLE_BEFORE = re.compile(r"\b(?:an?|the) \{\}", re.IGNORECASE)

_JOINERS = "\u200c\u200d"
"""Not seen themselves: they say how the letters of a word are joined, in Hindi and Persian"""

FUNCTION_WORDS = frozenset(
    {"a", "an", "the", "this", "that", "these", "those", "one", "some", "any", "and", "or"}
    | {"of", "on", "in", "at", "to", "with", "my", "your", "its", "his", "her", "their"}
)
"""Words that name nothing: not knowing them is no loss worth a warning."""


def words(text: str) -> list[str]:
    """Return the words of a text in lower case, without punctuation.

    Marks that many scripts write on and between letters (vowels of Hindi, tones of Thai) belong to
    the word; an accent and its letter are one character.
    """
    text = unicodedata.normalize("NFC", text.lower())
    if text.isascii():
        return _WORD.findall(text)
    # For the pattern a mark is a letter like any other.
    letters = "".join("a" if _is_mark(character) else character for character in text)
    found = (text[match.start() : match.end()] for match in _WORD.finditer(letters))
    return [word for word in found if any(character.isalnum() for character in word)]


def _is_mark(character: str) -> bool:
    return unicodedata.category(character).startswith("M") or character in _JOINERS


def normalised(phrase: str) -> str:
    """Return a phrase as models read it: words in lower case, single spaces.

    Raises:
        RefusedError: the phrase holds no word.
    """
    found = words(phrase)
    if not found:
        raise RefusedError(
            f"the phrase {phrase!r} holds no word; name an object, as in 'the red cup'"
        )
    return " ".join(found)


def fill(template: str, phrase: str) -> str:
    """Return the text for the model: the phrase in the template that the model was trained with.

    A template that ends in an article, as in "a photo of a {}", takes the phrase without its own.
    """
    if _ARTICLE_BEFORE.search(template):
        phrase = _ARTICLE.sub("", phrase)
    return template.replace("{}", phrase)


def check_template(template: str) -> str:
    """Return the template. Raises ConfigError where it has no place for the phrase."""
    if template.count("{}") != 1:
        raise ConfigError(
            f"phrase template {template!r}: expected exactly one '{{}}', as in 'a photo of a {{}}'"
        )
    return template


_SPELT_OTHERWISE = {"gray": "grey", "grey": "gray"}
"""Words that people spell in two ways"""


def spelt_as_known(phrase: str, vocabulary: Iterable[str] | None) -> str:
    """Return a phrase with words in a known spelling, where they have one.

    "E-mails" are emails, a "cereal-box" is a cereal box, "gray" is grey, "mugs" are each a mug. A
    word that is known, or in no spelling known, stays as it is; so do all where the vocabulary is
    not known.

    Args:
        phrase: As `normalised` returns it.
        vocabulary: Words of the training.
    """
    if vocabulary is None:
        return phrase
    known = FUNCTION_WORDS.union(vocabulary)
    return " ".join(_spelt_as_known(word, known) for word in phrase.split(" "))


def _spelt_as_known(word: str, known: frozenset[str]) -> str:
    joined = word.replace("-", "")
    spellings = (
        word,
        _SPELT_OTHERWISE.get(word, word),
        joined,
        word.replace("-", " "),
        *(joined.removesuffix(ending) for ending in ("s", "es")),
    )
    fitting = (one for one in spellings if known.issuperset(one.split(" ")))
    return next(fitting, word)


def unknown_words(phrase: str, vocabulary: Iterable[str] | None) -> list[str]:
    """Return the words of a phrase that no training phrase contained, in their order, once each.

    None for the vocabulary means that it is not known (a public checkpoint): nothing is called
    unknown.
    """
    if vocabulary is None:
        return []
    known = FUNCTION_WORDS.union(vocabulary)
    return list(dict.fromkeys(word for word in words(phrase) if word not in known))
