"""Schemas of answers that can only speak of what is there: words of the utterance, its scene.

`x-words-of` and `x-arithmetic-of` are understood by the language service, which makes a grammar of
them for every backend. What a model may say is decided here; what it means, by the modules.
"""

import re
from collections.abc import Iterable
from typing import Any

from w2c_dialogue.utterance import Utterance

LONGEST_PHRASE = 12
"""Words; the language service takes no more."""
MOST_NUMBERS = 64
"""As many as the language service takes."""
CONVENTIONS = (
    "0.1", "0.15", "0.2", "0.25", "0.3", "0.33", "0.4", "0.5", "0.6", "0.67", "0.7", "0.75", "0.8",
    "0.9", "1.5", "2.5", "2.54",
)  # fmt: skip
"""Shares and factors that words stand for: an edge, a quarter, `half of that`, an inch in cm"""
SPOKEN = tuple(str(number) for number in (*range(1, 21), *range(30, 101, 10)))
"""Numbers that are spoken as one word, however it is spelt; 20, 40 and 100 px are steps, too"""
_DIGITS = re.compile(r"[0-9]{1,6}(?:[.,][0-9]{1,3})?|[.,][0-9]{1,3}")


def words_of(utterance: Utterance) -> dict[str, Any]:
    """Return the schema of a phrase that stands in an utterance, word for word."""
    return {"type": "string", "x-words-of": utterance.text, "x-longest": LONGEST_PHRASE}


def arithmetic_of(symbols: Iterable[str], numbers: Iterable[str] | None) -> dict[str, Any]:
    """Return the schema of an expression in these symbols and numbers; None: any short number."""
    scene: dict[str, Any] = {"symbols": list(symbols)}
    if numbers is not None:
        scene["numbers"] = list(numbers)
    return {"type": "string", "x-arithmetic-of": scene}


def numbers_of(text: str) -> list[str]:
    """Return the numbers that may mean something: of a text as a model reads it, and conventions.

    Digits are as they stand there, `2,5` as `2.5`. A number word may be misspelt, so any number
    that is one word stands beside them.
    """
    typed = [_plain(digits) for digits in _DIGITS.findall(text)]
    return list(dict.fromkeys((*CONVENTIONS, *SPOKEN, *typed)))[:MOST_NUMBERS]


def _plain(digits: str) -> str:
    number = digits.replace(",", ".")
    return f"0{number}" if number.startswith(".") else number
