"""What things are for, in words that do not name them, for questions of training.

People say "thing to drink from" when they do not know a thing's name, or forgot it. A model that
learned names alone takes the words it knows in such a phrase for the name: the eggs, not the pan.
The phrases are in `uses.jsonl`.
"""

from functools import lru_cache
from pathlib import Path

import msgspec

_FILE = Path(__file__).with_name("uses.jsonl")


class Use(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What some kinds are for, as people say it, without an article in front.

    Kinds that are kept for judging are never among those that it fits: nobody is trained on them.
    """

    fits: tuple[str, ...]
    """Kinds for which each of the phrases is right"""
    may_fit: tuple[str, ...]
    """Others that somebody might mean: where one is shown, the answer is not that none fits"""
    phrases: tuple[str, ...]


_USE_OF = {
    phrase: use
    for use in msgspec.json.Decoder(Use).decode_lines(_FILE.read_bytes())
    for phrase in use.phrases
}
EVERY_USE = tuple(_USE_OF)
"""All phrases, each once"""


@lru_cache(maxsize=256)
def uses_of(kind: str) -> tuple[str, ...]:
    """Return the phrases that are right for a kind."""
    return tuple(phrase for phrase, use in _USE_OF.items() if kind in use.fits)


def fitting_kinds(phrase: str) -> frozenset[str]:
    """Return the kinds for which a bare phrase is right.

    Raises:
        KeyError: it is no phrase of `uses.jsonl`.
    """
    return frozenset(_USE_OF[phrase].fits)


def possible_kinds(phrase: str) -> frozenset[str]:
    """Return all kinds that a person might mean by a bare phrase, those it fits among them.

    Raises:
        KeyError: it is no phrase of `uses.jsonl`.
    """
    use = _USE_OF[phrase]
    return frozenset(use.fits + use.may_fit)


def is_use(phrase: str) -> bool:
    """Tell whether a bare phrase is one of `uses.jsonl`."""
    return phrase in _USE_OF
