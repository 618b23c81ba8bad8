"""One thing that could be said, and what whoever says it expects of it."""

from dataclasses import dataclass
from functools import cache

import numpy as np

from w2c_evaluation.corrections.eye import Pixel, Thing

_UNITS = [
    "zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven",
    "twelve", "thirteen", "fourteen", "fifteen", "sixteen", "seventeen", "eighteen", "nineteen",
]  # fmt: skip
_TENS = ["twenty", "thirty", "forty", "fifty", "sixty", "seventy", "eighty", "ninety"]


@dataclass(frozen=True)
class Saying:
    """Words for the robot."""

    text: str
    kind: str
    """Of phrasing"""
    meaning: str
    """The same for all words that mean the same"""
    lands: Pixel
    """Where the dot is expected then [px]"""
    leaves: float
    """How far from the ring that seems to be [px]"""
    thing: Thing | None = None
    """That is named first"""
    name: str = ""
    """What it is called"""
    belief: str = ""
    """Which belief about words it rests on; "" = on what is seen alone"""
    changes: bool = False
    """It speaks of the dot that is shown"""


class Chooser:
    """Draws words."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng

    def pick(self, texts: tuple[str, ...]) -> str:
        """Return one of several texts."""
        return texts[int(self._rng.integers(len(texts)))]

    def chance(self, share: float) -> bool:
        """Return True so often."""
        return bool(self._rng.random() < share)

    def name(self, thing: Thing, colour_share: float, unknown: frozenset[str]) -> str | None:
        """Return what a thing is called; None: the robot knows none of its names.

        Args:
            thing: It.
            colour_share: How often its colour is said where that is not needed.
            unknown: Names that the robot did not find.
        """
        plain = tuple(n for n in thing.names[: thing.plain_names] if n not in unknown)
        coloured = tuple(n for n in thing.names[thing.plain_names :] if n not in unknown)
        if coloured and (not plain or self.chance(colour_share)):
            return self.pick(coloured)
        # The first name is the usual one; who says another says it all the time.
        return plain[0] if plain and self.chance(0.7) else self.pick(plain) if plain else None


def sentence(template: str, **words: str) -> str:
    """Return a phrasing with its words, with a capital where it is written like a sentence."""
    text = template.format(**words)
    return text[0].upper() + text[1:] if template[-1] in ".!?" else text


@cache
def spelled(number: int) -> str:
    """Return a whole number below 100 in words."""
    if number < len(_UNITS):
        return _UNITS[number]
    tens, units = divmod(number, 10)
    return _TENS[tens - 2] + (f"-{_UNITS[units]}" if units else "")
