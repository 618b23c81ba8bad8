"""Strings that only say what the request already holds: words of a text, or arithmetic of a scene.

A small model that may write any phrase writes one that nobody said, and any number one that nothing
has. A request that wants neither says so in its schema, beside `"type": "string"`:

- `"x-words-of": TEXT`, with `"x-longest": N`: one to N neighbouring words of the text, as they
  stand there, without punctuation at their ends.
- `"x-arithmetic-of": {"symbols": [...], "numbers": [...]}`: sums and products of these symbols and
  numbers, brackets allowed; without `numbers`, of any short ones.

Both become a pattern, which every backend is checked against.
"""

from typing import Any

from w2c.errors import RefusedError

WORDS_OF = "x-words-of"
LONGEST = "x-longest"
ARITHMETIC_OF = "x-arithmetic-of"
KEYWORDS = (WORDS_OF, LONGEST, ARITHMETIC_OF)

MAX_WORDS = 100
MAX_LONGEST = 12
MAX_SYMBOLS = 64
MAX_SYMBOL = 40
MAX_NUMBERS = 64
TERMS = 5
"""Of a sum or product: a point that takes four moves back"""
_ENDS = ".,;:!?\"'()[]{}<>`*_~|\\/"
_SPECIAL = frozenset("\\.+*?()|[]{}^$/-&~#")
_SHORT_NUMBER = r"[0-9]{1,4}(\.[0-9]{1,2})?"


def bound_string(node: dict[str, Any], path: str) -> dict[str, Any]:
    """Return the checked schema of a node with one of the keywords: a pattern, and what it means.

    Raises:
        RefusedError: the keyword has no such value.
    """
    if WORDS_OF in node:
        words = _checked_words(node[WORDS_OF], path)
        longest = node.get(LONGEST, MAX_LONGEST)
        if not isinstance(longest, int) or not 1 <= longest <= MAX_LONGEST:
            raise _refuse(path, f"{LONGEST} is {longest!r:.40}, must be 1 to {MAX_LONGEST}")
        text = " ".join(words)
        return {
            "type": "string",
            "description": f"neighbouring words of this text, as they stand: {text}",
            "pattern": f"^{span_pattern(words, longest)}$",
        }
    symbols, numbers = _checked_scene(node[ARITHMETIC_OF], path)
    known = ", ".join([*symbols, *(numbers or ["numbers"])])
    return {
        "type": "string",
        "description": f"+ - * / and brackets between: {known}",
        "pattern": f"^{arithmetic_pattern(symbols, numbers)}$",
    }


def span_pattern(words: list[str], longest: int) -> str:
    """Return the expression of 1 to `longest` neighbouring words; those at its ends are bare."""
    return "(" + "|".join(_from(words, at, longest, first=True) for at in range(len(words))) + ")"


def _from(words: list[str], at: int, longest: int, *, first: bool) -> str:
    """Return the expression of the spans that begin at a word, or go on with it."""
    word = words[at].lstrip(_ENDS) if first else words[at]
    last = _escape(word.rstrip(_ENDS))
    if longest == 1 or at + 1 == len(words):
        return last
    rest = _from(words, at + 1, longest - 1, first=False)
    return f"({last}|{_escape(word)} {rest})"


def arithmetic_pattern(symbols: list[str], numbers: list[str] | None) -> str:
    """Return the expression of sums and products, with brackets around one inside."""
    allowed = [_escape(text) for text in (*symbols, *(numbers or ()))]
    atom = "(" + "|".join(allowed + ([] if numbers is not None else [_SHORT_NUMBER])) + ")"
    inner = _chain(atom)
    return _chain(rf"({atom}|\({inner}\))")


def _chain(factor: str) -> str:
    return f"-?{factor}( ?[-+*/] ?{factor}){{0,{TERMS - 1}}}"


def _escape(text: str) -> str:
    return "".join("\\" + character if character in _SPECIAL else character for character in text)


def _checked_words(text: object, path: str) -> list[str]:
    """Return the words that are more than punctuation."""
    if not isinstance(text, str):
        raise _refuse(path, f"{WORDS_OF} is {text!r:.40}, must be a text")
    words = [word for word in text.split() if word.strip(_ENDS)]
    if not 1 <= len(words) <= MAX_WORDS:
        raise _refuse(path, f"{WORDS_OF} has {len(words)} words, must have 1 to {MAX_WORDS}")
    if not all(word.isprintable() for word in words):
        raise _refuse(path, f"{WORDS_OF} holds control characters")
    return words


def _checked_scene(scene: object, path: str) -> tuple[list[str], list[str] | None]:
    if not isinstance(scene, dict) or not set(scene) <= {"symbols", "numbers"}:
        raise _refuse(path, f"{ARITHMETIC_OF} must be an object of symbols and numbers")
    symbols = _checked_texts(scene.get("symbols", []), "symbols", MAX_SYMBOLS, path)
    if scene.get("numbers") is None:
        return symbols, None
    numbers = _checked_texts(scene["numbers"], "numbers", MAX_NUMBERS, path)
    if not symbols and not numbers:
        raise _refuse(path, f"{ARITHMETIC_OF} has neither symbols nor numbers")
    for number in numbers:
        if not number.replace(".", "", 1).isdigit() or not number.isascii():
            raise _refuse(path, f"'{number}' of the numbers is none; a sign is part of the sum")
    return symbols, numbers


def _checked_texts(texts: object, name: str, most: int, path: str) -> list[str]:
    if not isinstance(texts, list) or len(texts) > most:
        raise _refuse(path, f"{name} must be a list of at most {most} texts")
    for text in texts:
        if not isinstance(text, str) or not 1 <= len(text) <= MAX_SYMBOL or not text.isprintable():
            raise _refuse(path, f"{text!r:.60} of {name} is no text of 1 to {MAX_SYMBOL} letters")
    return texts


def _refuse(path: str, reason: str) -> RefusedError:
    return RefusedError(f"schema at {path}: {reason}")
