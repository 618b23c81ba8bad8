"""Numbers of several words, as digits: `twenty five cm`, `an inch and a half`, `two zero cm`.

A small model copies digits well and reckons badly: it knows the words that are one number each, and
makes 20 of "twenty five". Number words, units and fractions are closed classes, so what they make
together is told here, for the model and for whoever bounds its numbers. Nobody pauses within a
number: a comma ends it.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass

from w2c.errors import RefusedError
from w2c_dialogue.utterance import Utterance

_SMALL = (
    "zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven",
    "twelve", "thirteen", "fourteen", "fifteen", "sixteen", "seventeen", "eighteen", "nineteen",
)  # fmt: skip
_TENS = ("twenty", "thirty", "forty", "fifty", "sixty", "seventy", "eighty", "ninety")
VALUES = dict(zip(_SMALL, range(20), strict=True)) | dict(
    zip(_TENS, range(20, 100, 10), strict=True)
)
"""Numbers that are one word"""
UNITS = frozenset(
    {
        "centimeter", "centimeters", "centimetre", "centimetres", "cm", "cms", "feet", "finger",
        "fingers", "foot", "inch", "inches", "m", "meter", "meters", "metre", "metres",
        "millimeter", "millimeters", "millimetre", "millimetres", "mm", "pixel", "pixels", "px",
        "step", "steps", "thumb", "thumbs",
    }
)  # fmt: skip
DIGITS = re.compile(r"(?P<sign>[+-]?)(?P<number>[0-9]{1,4}(?:[.,][0-9]{1,3})?)")
_FRACTION = re.compile(r"(?P<over>[0-9]{1,2})/(?P<under>[1-9][0-9]?)")
_POWER_OF_TEN = re.compile(r"[+-]?[0-9]+(?:[.,][0-9]+)?e[+-]?[0-9]+")
_AND = frozenset({"&", "and", "n"})
_ONE = frozenset({"a", "an", "one"})
_QUARTERS = {
    ("quarter",): 0.25,
    ("a", "quarter"): 0.25,
    ("one", "quarter"): 0.25,
    ("three", "quarter"): 0.75,
    ("three", "quarters"): 0.75,
    ("three-quarter",): 0.75,
    ("three-quarters",): 0.75,
}


@dataclass(frozen=True)
class _Number:
    """A number among words."""

    sign: str
    """As typed"""
    size: float
    end: int
    """Index of the word behind it"""

    def plus(self, more: float, end: int) -> "_Number":
        """Return a number farther from zero, that ends later."""
        return _Number(self.sign, self.size + more, end)

    def __str__(self) -> str:
        """Return its digits: a third is 0.33, as in `prompts.bound`."""
        return f"{self.sign}{round(self.size, 2):g}"


def in_digits(words: Sequence[str]) -> list[str]:
    """Return words with each number of several words, or with a fraction, as one word of digits.

    Args:
        words: In lower case but for letters of things; a comma behind a number stays behind it.
    """
    bare = [word.rstrip(",") for word in words]
    found: list[str] = []
    at = 0
    while at < len(words):
        read = _length(bare, at) or _compound(bare, at)
        if read is None or any(word.endswith(",") for word in words[at : read[1] - 1]):
            found.append(words[at])
            at += 1
            continue
        said, at = read
        found += said
        if words[at - 1].endswith(","):
            found[-1] += ","
    return found


def with_digits(utterance: Utterance) -> Utterance:
    """Return an utterance whose numbers are digits; where any were not, in words as models read.

    Its words count anew, so name none before.
    """
    words = tuple(in_digits(utterance.folded))
    return utterance if words == utterance.folded else Utterance(words, words, words)


def check_numbers(utterance: Utterance) -> None:
    """Refuse numbers such as `1e999`: a model would make another one of it.

    Raises:
        RefusedError: there is one; says which.
    """
    for word in utterance.folded:
        if _POWER_OF_TEN.fullmatch(word.rstrip(",")):
            raise RefusedError(
                f"I cannot read the number '{word.rstrip(',')[:20]}'. Nothing changed; please say "
                "it in plain digits, for example: 3 cm to the left."
            )


def _length(bare: Sequence[str], at: int) -> tuple[list[str], int] | None:
    """Read `three quarters of an inch`, `an inch and a half`: a fraction that needs its unit."""
    for quarters, share in _QUARTERS.items():
        end = at + len(quarters)
        if tuple(bare[at:end]) == quarters:
            end += 2 if bare[end : end + 1] == ["of"] and bare[end + 1 : end + 2] else 0
            if (end == at + len(quarters) or bare[end - 1] in _ONE) and _is_unit(bare, end):
                return [f"{share:g}", bare[end]], end + 1
    number = _Number("", 1.0, at + 1) if bare[at] in _ONE else _number(bare, at)
    if number is not None and _is_unit(bare, number.end) and _is_half(bare, number.end + 1):
        unit = bare[number.end]
        return [str(number.plus(0.5, number.end + 4)), unit], number.end + 4
    return None


def _compound(bare: Sequence[str], at: int) -> tuple[list[str], int] | None:
    """Read `two and a half`, `twenty five`, `1 1/2`: what is more than one plain word."""
    number = _number(bare, at)
    if number is None:
        return None
    if _is_half(bare, number.end):
        number = number.plus(0.5, number.end + 3)
    plain = number.end == at + 1 and (bare[at] in VALUES or DIGITS.fullmatch(bare[at]))
    return None if plain else ([str(number)], number.end)


def _is_unit(bare: Sequence[str], at: int) -> bool:
    return at < len(bare) and bare[at] in UNITS


def _is_half(bare: Sequence[str], at: int) -> bool:
    """Tell whether `and a half` stands there, of what was before and not of a unit behind it."""
    half = at + 2 < len(bare) and bare[at] in _AND and list(bare[at + 1 : at + 3]) == ["a", "half"]
    own_unit = _is_unit(bare, at + 3) and _is_unit(bare, at - 1)
    return half and not own_unit


def _number(bare: Sequence[str], at: int) -> _Number | None:
    """Return the number that begins there."""
    fraction = _FRACTION.fullmatch(bare[at])
    if fraction:
        return _Number("", int(fraction["over"]) / int(fraction["under"]), at + 1)
    digits = DIGITS.fullmatch(bare[at])
    if digits:
        number = _Number(digits["sign"], float(digits["number"].replace(",", ".")), at + 1)
        more = _FRACTION.fullmatch(bare[at + 1]) if at + 1 < len(bare) else None
        return number.plus(int(more["over"]) / int(more["under"]), at + 2) if more else number
    return _one_by_one(bare, at) or _hundreds(bare, at) or _below_hundred(bare, at)


def _one_by_one(bare: Sequence[str], at: int) -> _Number | None:
    """Read two or three digits that are said one by one, with a unit: `two zero cm`, `three five`.

    Only with a nought or a five at the end: "two three" may be two or three, as "four five" may.
    "One" in front of anything but noughts is a thing: `the red one five cm to the left`.
    """
    end = at
    while end < len(bare) and VALUES.get(bare[end], 10) < 10:
        end += 1
    digits = [VALUES[word] for word in bare[at:end]]
    whole = at == 0 or VALUES.get(bare[at - 1], 10) >= 10
    if not whole or not 2 <= len(digits) <= 3 or not _is_unit(bare, end):
        return None
    either = len(digits) == 2 and digits[1] == digits[0] + 1
    thing = digits[0] == 1 and any(digits[1:])
    if digits[0] == 0 or digits[-1] not in (0, 5) or either or thing:
        return None
    return _Number("", float("".join(map(str, digits))), end)


def _hundreds(bare: Sequence[str], at: int) -> _Number | None:
    """Read `a hundred`, `two hundred five`, and with a unit `one hundred and twenty px`."""
    count = 1 if bare[at] in _ONE else VALUES.get(bare[at], 0)
    if not 1 <= count <= 9 or bare[at + 1 : at + 2] != ["hundred"]:
        return None
    hundreds, end = _Number("", 100.0 * count, at + 2), at + 2
    joined = bare[end : end + 1] == ["and"]
    rest = _below_hundred(bare, end + joined) if end + joined < len(bare) else None
    if rest is None or (joined and not _is_unit(bare, rest.end)):
        return hundreds
    return hundreds.plus(rest.size, rest.end)


def _below_hundred(bare: Sequence[str], at: int) -> _Number | None:
    """Read `twenty`, `twenty five`, `twenty-five`."""
    tens, dash, ones = bare[at].partition("-")
    if tens not in VALUES:
        return None
    if dash:
        fits = tens in _TENS and 1 <= VALUES.get(ones, 0) <= 9
        return _Number("", float(VALUES[tens] + VALUES[ones]), at + 1) if fits else None
    number = _Number("", float(VALUES[tens]), at + 1)
    following = VALUES.get(bare[at + 1], 0) if at + 1 < len(bare) else 0
    return number.plus(following, at + 2) if tens in _TENS and 1 <= following <= 9 else number
