"""Numbers of several words, as digits: `twenty five cm`, `an inch and a half`, `two zero`.

A small model copies digits well and reckons badly: it knows the words that are one number each, and
makes 20 of "twenty five". Number words, units and fractions are closed classes, so what they make
together is told here, for the model and for whoever bounds its numbers.
"""

import re
from collections.abc import Sequence

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
        "fingers", "foot", "inch", "inches", "meter", "meters", "metre", "metres", "millimeter",
        "millimeters", "millimetre", "millimetres", "mm", "pixel", "pixels", "px", "step", "steps",
        "thumb", "thumbs",
    }
)  # fmt: skip
_AND = frozenset({"&", "and", "n"})
_ONE = frozenset({"a", "an", "one"})
_SIGN_AND_DIGITS = re.compile(r"[+-]?[0-9]{1,4}(?:\.[0-9]{1,3})?")
_FRACTION = re.compile(r"([0-9]{1,2})/([0-9]{1,2})")
_ONE_BY_ONE = range(2, 4)
"""How many digits are said one by one, the last a nought or a five: `two zero`, `one five`. "Two
three" may be two or three"""


def in_digits(words: Sequence[str]) -> list[str]:
    """Return words with each number of several words, or with a fraction, as one word of digits.

    Args:
        words: In lower case; a comma behind a word stays behind the number.
    """
    found: list[str] = []
    at = 0
    while at < len(words):
        said, end = _length(words, at)
        if end == at + 1 and not _is_compound(words[at]):
            said = [words[at]]
        elif words[end - 1].endswith(","):
            said[-1] += ","
        found += said
        at = end
    return found


def with_digits(utterance: Utterance) -> Utterance:
    """Return an utterance whose numbers are digits. Its words count anew, so name none before."""
    words = tuple(in_digits(utterance.folded))
    return utterance if words == utterance.folded else Utterance(words, words, words)


def _is_compound(word: str) -> bool:
    """Tell whether one word is several: `twenty-five`, `1/2`."""
    return "/" in word or (word[0].isalpha() and "-" in word)


def _length(words: Sequence[str], at: int) -> tuple[list[str], int]:
    """Return a number, with its unit where a fraction stands behind it, and where it ends."""
    for read in (_part_of_unit, _unit_and_half, _number_and_half):
        length = read(words, at)
        if length is not None:
            return length
    number = _number(words, at)
    return ([words[at]], at + 1) if number is None else ([_text(number[0])], number[1])


def _part_of_unit(words: Sequence[str], at: int) -> tuple[list[str], int] | None:
    """Read `a quarter of an inch`, `three quarters of a metre`, `quarter inch`."""
    heard = [_bare(word) for word in words[at : at + 5]]
    share, rest = 0.25, heard
    if heard[:1] in (["a"], ["one"]):
        rest = heard[1:]
    elif heard[:2] in (["three", "quarters"], ["three", "quarter"]):
        share, rest = 0.75, ["quarter", *heard[2:]]
    if rest[:1] != ["quarter"]:
        return None
    behind = rest[1:]
    if behind[:1] == ["of"]:
        behind = behind[2:] if behind[1:2] and behind[1] in _ONE else []
    elif behind[:1] and behind[0] in _ONE:
        behind = behind[1:]
    if not behind or behind[0] not in UNITS:
        return None
    dropped = len(heard) - len(behind)
    return [_text(share), behind[0]], at + dropped + 1


def _unit_and_half(words: Sequence[str], at: int) -> tuple[list[str], int] | None:
    """Read `an inch and a half`, `two centimetres and a half`."""
    number = (1.0, at + 1) if _bare(words[at]) in _ONE else _number(words, at)
    if number is None or number[1] >= len(words):
        return None
    value, unit = number
    if _bare(words[unit]) in UNITS and _is_half(words, unit + 1):
        return [_text(value + 0.5), _bare(words[unit])], unit + 4
    return None


def _number_and_half(words: Sequence[str], at: int) -> tuple[list[str], int] | None:
    """Read `two and a half`."""
    number = _number(words, at)
    if number is None or not _is_half(words, number[1]):
        return None
    return [_text(number[0] + 0.5)], number[1] + 3


def _is_half(words: Sequence[str], at: int) -> bool:
    heard = [_bare(word) for word in words[at : at + 3]]
    return len(heard) == 3 and heard[0] in _AND and heard[1:] == ["a", "half"]


def _number(words: Sequence[str], at: int) -> tuple[float, int] | None:
    """Return the value of the number that begins there, and where it ends."""
    digits = _FRACTION.fullmatch(_bare(words[at]))
    if digits and int(digits[2]):
        return int(digits[1]) / int(digits[2]), at + 1
    if _SIGN_AND_DIGITS.fullmatch(_bare(words[at])):
        fraction = _FRACTION.fullmatch(_bare(words[at + 1])) if at + 1 < len(words) else None
        if fraction and int(fraction[2]) and not words[at].endswith(","):
            return float(_bare(words[at])) + int(fraction[1]) / int(fraction[2]), at + 2
        return float(_bare(words[at])), at + 1
    return _one_by_one(words, at) or _hundreds(words, at) or _below_hundred(words, at)


def _one_by_one(words: Sequence[str], at: int) -> tuple[float, int] | None:
    """Read digits that are said one by one: `two zero`, `one five`."""
    digits = ""
    end = at
    while end < len(words) and VALUES.get(_bare(words[end]), 10) < 10:
        digits += str(VALUES[_bare(words[end])])
        end += 1
        if words[end - 1].endswith(","):
            break
    if len(digits) in _ONE_BY_ONE and digits[-1] in "05" and digits[0] != "0":
        return float(digits), end
    return None


def _hundreds(words: Sequence[str], at: int) -> tuple[float, int] | None:
    """Read `a hundred`, `one hundred and twenty`, `two hundred five`."""
    first = _bare(words[at])
    count = 1 if first in _ONE else VALUES.get(first, 0)
    behind = at + 1 < len(words) and _bare(words[at + 1]) == "hundred"
    if not 1 <= count <= 9 or not behind or words[at].endswith(","):
        return None
    end = at + 2
    if words[end - 1].endswith(","):
        return 100.0 * count, end
    more = end + 1 if end < len(words) and _bare(words[end]) == "and" else end
    rest = _below_hundred(words, more) if more < len(words) else None
    return (100.0 * count, end) if rest is None else (100.0 * count + rest[0], rest[1])


def _below_hundred(words: Sequence[str], at: int) -> tuple[float, int] | None:
    """Read `twenty`, `twenty five`, `twenty-five`."""
    tens, dash, ones = _bare(words[at]).partition("-")
    if tens not in VALUES:
        return None
    if dash:
        good = tens in _TENS and 1 <= VALUES.get(ones, 0) <= 9
        return (float(VALUES[tens] + VALUES[ones]), at + 1) if good else None
    following = _bare(words[at + 1]) if at + 1 < len(words) else ""
    if tens in _TENS and 1 <= VALUES.get(following, 0) <= 9 and not words[at].endswith(","):
        return float(VALUES[tens] + VALUES[following]), at + 2
    return float(VALUES[tens]), at + 1


def _bare(word: str) -> str:
    return word.rstrip(",")


def _text(value: float) -> str:
    return f"{round(value, 3):g}"
