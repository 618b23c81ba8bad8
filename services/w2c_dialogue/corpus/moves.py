"""Corrections of the hand-written corpus, as its authors note them: `left bit + up {3}cm`.

The note becomes the expressions of the new target (`w2c_dialogue.expressions`).
"""

from collections.abc import Callable, Sequence

from w2c.errors import ConfigError
from w2c_dialogue.corpus.places import Place, length, read_place
from w2c_dialogue.corpus.steering import WAYS, term

STEPS = {"tiny": "10", "bit": "20", "step": "40", "lot": "100"}
"""Pixels of an amount in words"""
_ALONG = {"u": 0, "v": 1}
_EDGES_ALONG = {"u": ("left", "right"), "v": ("top", "bottom")}


def read_move(text: str) -> tuple[Place, int]:
    """Return the new target of a note, and how many earlier corrections it speaks of.

    Raises:
        ConfigError: it is none.
    """
    name, *arguments = text.split()
    try:
        if name in WAYS:
            return _ways(text), 0
        return _READERS[name](arguments)
    except (KeyError, ValueError, IndexError) as error:
        raise ConfigError(
            f"'{text}' is no correction; known: {', '.join((*WAYS, *_READERS))}"
        ) from error


def _ways(text: str) -> Place:
    """Read directions with amounts, joined by +."""
    symbols = ["target.u", "target.v"]
    for part in text.split("+"):
        way, *amounts = part.split()
        axis = 0 if WAYS[way][0] else 1
        if symbols[axis] not in ("target.u", "target.v"):
            raise ValueError(text)
        symbols[axis] = term(symbols[axis], sum(WAYS[way]), _size(amounts))
    return Place(symbols[0], symbols[1])


def _size(amounts: Sequence[str]) -> str:
    if not amounts:
        return STEPS["step"]
    (amount,) = amounts
    if amount.endswith("steps"):
        return f"{_number(amount.removesuffix('steps'))}*{STEPS['step']}"
    return STEPS[amount] if amount in STEPS else length(amount)


def _number(text: str) -> str:
    float(text)
    return text


def _again(arguments: Sequence[str]) -> tuple[Place, int]:
    """Add the last move so many times; less than 0 takes it back."""
    share = float(_number(arguments[0]))
    sign = "-" if share < 0.0 else "+"
    factor = "" if abs(share) == 1.0 else f"{abs(share):g}*"
    return Place(f"target.u{sign}{factor}last.du", f"target.v{sign}{factor}last.dv"), 1


def _turn(arguments: Sequence[str]) -> tuple[Place, int]:
    """Go as far as the last time, times a factor, in another direction."""
    du, dv = WAYS[arguments[0]]
    share = float(_number(arguments[1]))
    size = "last.size" if share == 1.0 else f"{share:g}*last.size"
    return Place(term("target.u", du, size), term("target.v", dv, size)), 1


def _undo(arguments: Sequence[str]) -> tuple[Place, int]:
    count = int(arguments[0])
    if not 1 <= count <= 4:
        raise ValueError(count)
    moves = ["last", *(f"moves[-{back}]" for back in range(2, count + 1))]
    u, v = ("".join(f"-{move}.{axis}" for move in moves) for axis in ("du", "dv"))
    return Place(f"target.u{u}", f"target.v{v}"), count


def _towards(sign: str) -> Callable[[Sequence[str]], tuple[Place, int]]:
    def read(arguments: Sequence[str]) -> tuple[Place, int]:
        letter, share = _letter(arguments[0]), _number(arguments[1])
        u, v = (f"target.{x}{sign}{share}*({letter}.{x}-target.{x})" for x in "uv")
        return Place(u, v), 0

    return read


def _length_towards(sign: str) -> Callable[[Sequence[str]], tuple[Place, int]]:
    def read(arguments: Sequence[str]) -> tuple[Place, int]:
        letter, size = _letter(arguments[0]), _size(arguments[1:])
        u, v = (f"target.{x}{sign}{size}*{letter}.way.{x}" for x in "uv")
        return Place(u, v), 0

    return read


def _length_along_last(sign: str) -> Callable[[Sequence[str]], tuple[Place, int]]:
    def read(arguments: Sequence[str]) -> tuple[Place, int]:
        size = _size(arguments)
        u, v = (f"target.{x}{sign}{size}*last.way.{x}" for x in "uv")
        return Place(u, v), 1

    return read


def _earlier(move: str) -> Callable[[Sequence[str]], tuple[Place, int]]:
    """Repeat a move that is not the last (1), or take it back (-1)."""

    def read(arguments: Sequence[str]) -> tuple[Place, int]:
        sign = {"1": "+", "-1": "-"}[arguments[0]]
        return Place(f"target.u{sign}{move}.du", f"target.v{sign}{move}.dv"), 2

    return read


def _onto(arguments: Sequence[str]) -> tuple[Place, int]:
    letter = _letter(arguments[0])
    return Place(f"{letter}.u", f"{letter}.v"), 0


def _align(axis: str) -> Callable[[Sequence[str]], tuple[Place, int]]:
    def read(arguments: Sequence[str]) -> tuple[Place, int]:
        letter, *part = arguments
        if part and part[0] not in _EDGES_ALONG[axis]:
            raise ValueError(part)
        symbols = ["target.u", "target.v"]
        symbols[_ALONG[axis]] = f"{_letter(letter)}.{part[0] if part else axis}"
        return Place(symbols[0], symbols[1]), 0

    return read


def _object_sized(arguments: Sequence[str]) -> tuple[Place, int]:
    way, share, thing = arguments
    du, dv = WAYS[way]
    measure = f"{_letter(thing)}.{'width' if du else 'height'}"
    size = measure if float(share) == 1.0 else f"{share}*{measure}"
    return Place(term("target.u", du, size), term("target.v", dv, size)), 0


def _pixel(arguments: Sequence[str]) -> tuple[Place, int]:
    return Place(_number(arguments[0]), _number(arguments[1])), 0


def _letter(text: str) -> str:
    if text not in ("A", "B", "C"):
        raise ValueError(text)
    return text.lower()


_READERS: dict[str, Callable[[Sequence[str]], tuple[Place, int]]] = {
    "again": _again,
    "turn": _turn,
    "undo": _undo,
    "start": lambda _: (Place("start.u", "start.v"), 1),
    "closer": _towards("+"),
    "away": _towards("-"),
    "towards": _length_towards("+"),
    "off": _length_towards("-"),
    "on": _length_along_last("+"),
    "back": _length_along_last("-"),
    "first": _earlier("first"),
    "before": _earlier("moves[-2]"),
    "onto": _onto,
    "place": lambda arguments: (read_place(" ".join(arguments)), 0),
    "align_u": _align("u"),
    "align_v": _align("v"),
    "size": _object_sized,
    "pixel": _pixel,
    "stay": lambda _: (Place("target.u", "target.v"), 0),
}
