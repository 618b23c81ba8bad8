"""Phrases that are watched for: what is never touched, and what may not bear a hand."""

import re
from collections.abc import Sequence

from w2c.errors import ConfigError

MAX_PHRASES = 32
"""As many as one look at a picture takes"""
MAX_CHARACTERS = 100

VETOED = ("person", "human hand", "face", "child", "dog", "cat", "flame")
"""What is never touched, unless configured otherwise"""

FRAGILE = {
    "glass": "may break under my weight",
    "window": "may break under my weight, or swing open",
    "mirror": "may break under my weight",
    "screen": "may break where I press on it",
    "cloth": "may slip, and hides what lies beneath",
    "paper": "may slip or tear, and hides what lies beneath",
    "cardboard": "may give way under my weight",
    "cushion": "is soft and gives way",
}
"""What may not bear a hand, and why"""
_ELSE = "may not bear my weight"

_WORD = re.compile(r"[^\W_]+")


def check_phrases(phrases: Sequence[str]) -> tuple[str, ...]:
    """Return phrases, each once. Raises ConfigError for too many, empty or long ones."""
    for phrase in phrases:
        if not content(phrase) or len(phrase) > MAX_CHARACTERS:
            raise ConfigError(
                f"'{phrase[:40]}' is no phrase to watch for: it needs a word, and at most "
                f"{MAX_CHARACTERS} characters; see --veto and --fragile"
            )
    once = tuple(dict.fromkeys(phrases))
    if len(once) > MAX_PHRASES:
        raise ConfigError(
            f"{len(once)} phrases to watch for, limit {MAX_PHRASES} for --veto and --fragile "
            "together"
        )
    return once


def content(text: str) -> frozenset[str]:
    """Return the words of a text that name something, in lower case and without plural s."""
    words = _WORD.findall(text.lower().replace("\u2019", "'").replace("'s", ""))
    return frozenset(_singular(word) for word in words) - _ARTICLES


def named_in(text: str, phrases: Sequence[str]) -> tuple[str, ...]:
    """Return the phrases all of whose words a text names: `person` in `the person's arm`."""
    words = content(text)
    return tuple(phrase for phrase in phrases if content(phrase) <= words)


def fragility(phrase: str) -> str:
    """Return why something may not bear a hand, for the operator: `glass: may break ...`."""
    return f"{phrase}: {FRAGILE.get(phrase, _ELSE)}"


def _singular(word: str) -> str:
    plural = len(word) > 3 and word.endswith("s") and not word.endswith("ss")
    return word[:-1] if plural else word


_ARTICLES = frozenset({"a", "an", "the", "of"})
