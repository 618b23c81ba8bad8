"""Arithmetic of models, parsed and never evaluated as code.

    sum     = product { ("+" | "-") product }
    product = factor { ("*" | "/") factor }
    factor  = ("+" | "-") factor | "(" sum ")" | number | symbol
    symbol  = name [ "[-" digits "]" ] { "." name }

Symbols are quantities of the scene in pixels (see `object_symbols` and `correction_symbols`). What
a model writes is input from a stranger: length, depth and size are bounded, and every fault is a
ModelError that says what is wrong.
"""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from w2c.errors import ModelError
from w2c.messages import Box
from w2c_dialogue.prompts.base import CorrectionScene
from w2c_dialogue.utterance import LETTERS

MAX_LENGTH = 200
MAX_DEPTH = 12
MAX_VALUE = 1e6
"""No quantity of a picture is larger [px]."""
MARGIN = 1.0
"""A clipped point stays this far inside the border of the picture [px]."""

_TOKEN = re.compile(
    r"\s*(?:(?P<number>[0-9]+(?:\.[0-9]*)?|\.[0-9]+)|(?P<symbol>[a-z]+(?:\[-[0-9]{1,3}\])?(?:\.[a-z]+){0,2})|(?P<sign>[-+*/()]))",
    re.ASCII,
)


class UnknownSymbolError(ModelError):
    """An expression names something that the scene does not have."""

    def __init__(self, symbol: str, known: Sequence[str]) -> None:
        super().__init__(f"'{symbol}' is not known here; known: {', '.join(known) or 'nothing'}")
        self.symbol = symbol


@dataclass(frozen=True)
class ImagePoint:
    """A point of a picture [px]."""

    u: float
    v: float
    clipped: bool
    """The expression named a point outside the picture; this is the nearest one inside."""


def evaluate(text: str, symbols: Mapping[str, float]) -> float:
    """Return the value of an expression.

    Raises:
        ModelError: it is not an expression, too long, too deep, divides by zero or overflows.
        UnknownSymbolError: a symbol is not in `symbols`.
    """
    if len(text) > MAX_LENGTH:
        raise ModelError(f"an expression of {len(text)} characters; the limit is {MAX_LENGTH}")
    parser = _Parser(_tokens(text), symbols, text)
    value = parser.sum(0)
    parser.expect_end()
    return value


def evaluate_point(
    x: str, y: str, symbols: Mapping[str, float], size: tuple[int, int]
) -> ImagePoint:
    """Return the point of two expressions, clipped to a picture of this (width, height) [px]."""
    return clip(evaluate(x, symbols), evaluate(y, symbols), size)


def clip(u: float, v: float, size: tuple[int, int]) -> ImagePoint:
    """Return a point, or the nearest one inside a picture of this (width, height) [px]."""
    inside_u = min(max(u, MARGIN), size[0] - MARGIN)
    inside_v = min(max(v, MARGIN), size[1] - MARGIN)
    return ImagePoint(inside_u, inside_v, clipped=not (0 <= u <= size[0] and 0 <= v <= size[1]))


def object_symbols(boxes: Sequence[Box], pixels_per_cm: float) -> dict[str, float]:
    """Return the symbols of objects, `a`, `b`, `c` in order of mention, and of `cm` [px]."""
    symbols = {"cm": pixels_per_cm}
    for letter, box in zip(LETTERS, boxes, strict=False):
        symbols |= {
            f"{letter}.left": box.left,
            f"{letter}.right": box.right,
            f"{letter}.top": box.top,
            f"{letter}.bottom": box.bottom,
            f"{letter}.width": box.right - box.left,
            f"{letter}.height": box.bottom - box.top,
            f"{letter}.u": 0.5 * (box.left + box.right),
            f"{letter}.v": 0.5 * (box.top + box.bottom),
        }
    return symbols


def correction_symbols(scene: CorrectionScene) -> dict[str, float]:
    """Return the objects' symbols, `target`, `start`, and the moves.

    `moves[-1]` = `last`, `moves[-2]` ... and `first` are (du, dv) [px]. A `way` has no unit and the
    length 1: `last.way` is that of the last move, `a.way` goes from the target to the object's
    middle. It is 0 where there is none.
    """
    symbols = object_symbols([o.box for o in scene.objects], scene.pixels_per_cm)
    u, v = scene.target
    for letter in LETTERS[: len(scene.objects)]:
        symbols |= _way(letter, symbols[f"{letter}.u"] - u, symbols[f"{letter}.v"] - v)
    symbols |= {"target.u": scene.target[0], "target.v": scene.target[1]}
    symbols |= {"start.u": scene.start[0], "start.v": scene.start[1]}
    for back, move in enumerate(reversed(scene.moves), 1):
        values = {"du": move.du, "dv": move.dv, "size": math.hypot(move.du, move.dv)}
        symbols |= {f"moves[-{back}].{name}": value for name, value in values.items()}
        if back == 1:
            symbols |= {f"last.{name}": value for name, value in values.items()}
            symbols |= _way("last", move.du, move.dv)
    if scene.moves:
        symbols |= {"first.du": scene.moves[0].du, "first.dv": scene.moves[0].dv}
    return symbols


def _way(name: str, du: float, dv: float) -> dict[str, float]:
    length = math.hypot(du, dv) or 1.0
    return {f"{name}.way.u": du / length, f"{name}.way.v": dv / length}


def _tokens(text: str) -> list[tuple[str, str]]:
    """Cut an expression into (kind, text)."""
    tokens = []
    at, end = 0, len(text.rstrip())
    while at < end:
        match = _TOKEN.match(text, at)
        if match is None:
            raise ModelError(f"'{text[at : at + 10]}' in '{text}' is no part of an expression")
        tokens.append((match.lastgroup or "", match[match.lastgroup or 0]))
        at = match.end()
    return tokens


class _Parser:
    """Recursive descent over the tokens, values computed on the way."""

    def __init__(
        self, tokens: list[tuple[str, str]], symbols: Mapping[str, float], text: str
    ) -> None:
        self._tokens = tokens
        self._symbols = symbols
        self._text = text
        self._at = 0

    def sum(self, depth: int) -> float:
        """Parse products with + and - between them."""
        value = self._product(depth)
        while self._sees("+", "-"):
            sign = self._take()
            term = self._product(depth)
            value = self._bounded(value + term if sign == "+" else value - term)
        return value

    def expect_end(self) -> None:
        """Refuse anything after the expression."""
        if self._at < len(self._tokens):
            raise ModelError(
                f"'{self._tokens[self._at][1]}' does not belong at its place in '{self._text}'"
            )

    def _product(self, depth: int) -> float:
        value = self._factor(depth)
        while self._sees("*", "/"):
            sign = self._take()
            factor = self._factor(depth)
            if sign == "/" and factor == 0.0:
                raise ModelError(f"'{self._text}' divides by zero")
            value = self._bounded(value * factor if sign == "*" else value / factor)
        return value

    def _factor(self, depth: int) -> float:
        if depth > MAX_DEPTH:
            raise ModelError(f"an expression nested deeper than {MAX_DEPTH}")
        if self._at >= len(self._tokens):
            raise ModelError(f"'{self._text}' ends where a number or a symbol is expected")
        kind, text = self._tokens[self._at]
        self._at += 1
        if kind == "number":
            return self._bounded(float(text))
        if kind == "symbol":
            return self._symbol(text)
        if text in "+-":
            value = self._factor(depth + 1)
            return value if text == "+" else -value
        if text == "(":
            value = self.sum(depth + 1)
            if not self._sees(")"):
                raise ModelError(f"a parenthesis of '{self._text}' is not closed")
            self._take()
            return value
        raise ModelError(f"'{text}' does not belong at its place in '{self._text}'")

    def _symbol(self, name: str) -> float:
        if name not in self._symbols:
            raise UnknownSymbolError(name, sorted(self._symbols))
        return self._bounded(self._symbols[name])

    def _bounded(self, value: float) -> float:
        if not abs(value) <= MAX_VALUE:
            raise ModelError(f"a value in '{self._text}' is {value:g}; the limit is {MAX_VALUE:g}")
        return value

    def _sees(self, *signs: str) -> bool:
        return self._at < len(self._tokens) and self._tokens[self._at][1] in signs

    def _take(self) -> str:
        self._at += 1
        return self._tokens[self._at - 1][1]
