"""What a model's text says: places, or that there are none. Pure functions.

The text is input from a stranger: bounded in length and number, and refused where it says neither.
"""

import json
import re
from dataclasses import dataclass

from w2c.chat_server import extract_json
from w2c.errors import ModelError
from w2c_grounding.pointer.formats import PARSERS
from w2c_grounding.pointer.options import Format
from w2c_grounding.pointer.places import Place

MAX_TEXT = 20_000
"""Characters of an answer; forty places take a thousand"""

MAX_PLACES = 64
"""Of one answer; more are a model that repeats itself, and are dropped"""

_LONGEST_DENIAL = 300
"""Characters: a longer text without places is prose about something else"""

_DENIAL = re.compile(
    r"\b(?:none|null|nothing|no such|not (?:found|visible|present|there|in|see|find|any|appear)"
    r"|(?:is|are) no\b|can(?:not|['\u2019]?t)\b|(?:do|does|is|are)n['\u2019]?t\b|unable|absent)",
    re.IGNORECASE,
)


@dataclass(frozen=True)
class Reading:
    """What an answer says."""

    places: tuple[Place, ...]
    """Empty: the model says that nothing fits"""
    dropped: int
    """Places beyond `MAX_PLACES`"""


def read_answer(text: str, expected: Format = "auto") -> Reading:
    """Return the places that an answer names, in the first format that finds any.

    Raises:
        ModelError: it is too long, or says neither where something is nor that it is not there.
    """
    if len(text) > MAX_TEXT:
        raise ModelError(
            f"the model answered with {len(text)} characters, limit {MAX_TEXT}; "
            "limit its tokens, or use a model that answers with coordinates"
        )
    names = list(PARSERS) if expected == "auto" else [expected]
    for name in names:
        places = PARSERS[name](text)
        if places:
            return Reading(tuple(places[:MAX_PLACES]), max(0, len(places) - MAX_PLACES))
    if denies(text):
        return Reading((), 0)
    raise ModelError(f"the model names no place and does not say that there is none: '{text:.80}'")


def denies(text: str) -> bool:
    """Tell whether a text without places says that nothing fits."""
    found = extract_json(text)
    try:
        value = json.loads(found)
    except (ValueError, RecursionError):
        return len(text) <= _LONGEST_DENIAL and _DENIAL.search(text) is not None
    return _is_empty(value)


def _is_empty(value: object) -> bool:
    """Tell whether a JSON value holds nothing but names: `[]`, `null`, `{"points": []}`."""
    if isinstance(value, dict):
        return all(_is_empty(inner) or isinstance(inner, str) for inner in value.values())
    if isinstance(value, list):
        return all(_is_empty(inner) for inner in value)
    if isinstance(value, str):
        return _DENIAL.search(value) is not None
    return value is None or value is False
