"""A regular expression as a GBNF rule: what may stand between the quotes of a JSON string."""

from w2c.errors import RefusedError

_CLASSES = {
    "d": [("0", "9")],
    "w": [("a", "z"), ("A", "Z"), ("0", "9"), ("_", "_")],
    "s": [(" ", " ")],  # other white space is written as an escape in JSON
}
_NEEDS_ESCAPE = ('"', "\\")
PLAIN = r'[^"\\\x00-\x1F\x7F]'
"""A character that JSON writes as it is"""
_OPERATORS = "|)*+?{"

Ranges = list[tuple[str, str]]


def pattern_rule(pattern: str, longest: int) -> str:
    """Return the rule of a pattern from ^ to $.

    Args:
        pattern: As `check_schema` lets through.
        longest: Stands for "any number" in `*`, `+` and `{3,}`.

    Raises:
        RefusedError: it needs what GBNF has not: look-ahead, references, lazy repetition.
    """
    parser = _Parser(pattern[1:-1], longest)
    rule = parser.alternatives()
    if parser.rest:
        raise parser.refuse("a bracket closes that was not opened")
    return rule


def literal(text: str) -> str:
    """Return a text as a GBNF literal."""
    return '"' + "".join(_in_literal(character) for character in text) + '"'


def _in_literal(character: str) -> str:
    if character in _NEEDS_ESCAPE:
        return "\\" + character
    if ord(character) < 0x20 or ord(character) == 0x7F:
        return f"\\x{ord(character):02X}"
    return character


def _in_class(character: str) -> str:
    code = ord(character)
    if character.isalnum() and code < 0x80:
        return character
    return f"\\x{code:02X}" if code < 0x80 else f"\\U{code:08X}"


class _Parser:
    def __init__(self, text: str, longest: int) -> None:
        self._text = text
        self._longest = longest
        self._at = 0

    @property
    def rest(self) -> str:
        """What was not read yet."""
        return self._text[self._at :]

    def refuse(self, why: str) -> RefusedError:
        """Return the error of a pattern that has no GBNF form."""
        return RefusedError(
            f"schema: pattern '{self._text:.80}' has no GBNF form: {why} at character {self._at}; "
            "use --constraint llguidance or a simpler pattern"
        )

    def alternatives(self) -> str:
        """Read `a|b|c`."""
        parts = [self._sequence()]
        while self._eat("|"):
            parts.append(self._sequence())
        return " | ".join(parts)

    def _sequence(self) -> str:
        parts: list[str] = []
        while self.rest and self.rest[0] not in "|)":
            parts.append(self._atom() + self._repetition())
        return " ".join(parts) or '""'

    def _atom(self) -> str:
        character = self._take()
        if character == "(":
            if self._eat("?") and not self._eat(":"):
                raise self.refuse("a special group")
            inner = self.alternatives()
            if not self._eat(")"):
                raise self.refuse("a bracket is not closed")
            return f"({inner})"
        if character == "[":
            return self._class()
        if character == ".":
            return PLAIN
        if character == "\\":
            return self._escape()
        if character in "^$*+?{":
            raise self.refuse(f"'{character}'")
        return literal(self._plain(character))

    def _escape(self) -> str:
        character = self._take()
        if character in _CLASSES:
            return _class_text(_CLASSES[character])
        if character.isalnum():
            raise self.refuse(f"'\\{character}'")
        return literal(self._plain(character))

    def _class(self) -> str:
        negated = self._eat("^")
        ranges: Ranges = []
        while not self._eat("]") or not ranges:
            ranges += self._class_item(first=not ranges)
        if negated:
            return f"[^{_ranges_text(ranges)}" + PLAIN[2:]
        plain = [part for low, high in ranges for part in _without_escaped(low, high)]
        if not plain:
            raise self.refuse("a class with only characters that JSON escapes")
        return _class_text(plain)

    def _class_item(self, *, first: bool) -> Ranges:
        # A bracket that closes nothing stands for itself, as in [])].
        low = "]" if first and self._text[self._at - 1] == "]" else self._take()
        if low == "\\":
            low = self._take()
            if low in _CLASSES:
                return _CLASSES[low]
            if low.isalnum():
                raise self.refuse(f"'\\{low}' in a class")
        if self.rest[:1] == "-" and self.rest[1:2] not in ("]", ""):
            self._at += 1
            high = self._take()
            if high == "\\":
                high = self._take()
            return [(low, high)]
        return [(low, low)]

    def _repetition(self) -> str:
        if self._eat("{"):
            inside, closed, _ = self.rest.partition("}")
            low, comma, high = inside.partition(",")
            if not closed or not (low or high).isdigit():
                raise self.refuse("a repetition that is none")
            self._at += len(inside) + 1
            most = high or (str(max(self._longest, int(low))) if comma else low)
            text = f"{{{low or 0},{most}}}"
        elif self._eat("*"):
            text = f"{{0,{self._longest}}}"
        elif self._eat("+"):
            text = f"{{1,{self._longest}}}"
        elif self._eat("?"):
            text = "?"
        else:
            return ""
        if self.rest[:1] in ("?", "+"):
            raise self.refuse("a lazy or possessive repetition")
        return text

    def _plain(self, character: str) -> str:
        """Return a literal character. A quote or a backslash is escaped, as JSON writes it."""
        if ord(character) < 0x20:
            raise self.refuse("a control character")
        return "\\" + character if character in _NEEDS_ESCAPE else character

    def _take(self) -> str:
        if not self.rest:
            raise self.refuse("it ends too early")
        self._at += 1
        return self._text[self._at - 1]

    def _eat(self, character: str) -> bool:
        found = self.rest.startswith(character)
        self._at += found
        return found


def _without_escaped(low: str, high: str) -> Ranges:
    """Return the parts of a range that JSON writes as they are."""
    parts: Ranges = []
    begin = max(ord(low), 0x20)
    for special in (*map(ord, _NEEDS_ESCAPE), ord(high) + 1):
        end = min(special - 1, ord(high))
        if begin <= end:
            parts.append((chr(begin), chr(end)))
        begin = max(begin, special + 1)
    return parts


def _class_text(ranges: Ranges) -> str:
    return f"[{_ranges_text(ranges)}]"


def _ranges_text(ranges: Ranges) -> str:
    return "".join(
        _in_class(low) if low == high else f"{_in_class(low)}-{_in_class(high)}"
        for low, high in ranges
    )
