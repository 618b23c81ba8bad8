"""What an operator says to push the shown point to the wanted one, and what that means literally.

Directions and sizes are those of the picture. A tiny bit is 10 px, a bit 20, no size 40, a lot
100; a centimetre is what the operator sees it to be at the wanted place; "that" is the last move
that was seen. Whatever is said here brings the point nearer when it is understood so.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import hypot

import numpy as np

from w2c_evaluation.scenarios.sight import Pixel, Sight

SIZES: dict[float, tuple[str, ...]] = {
    10.0: ("a tiny bit", "just a touch"),
    20.0: ("a bit", "slightly", "a little bit"),
    40.0: ("",),
    100.0: ("a lot",),
}
"""Pixels, and the words for them"""
SMALLEST = min(SIZES)
ACROSS = {-1: ("to the left", "left"), 1: ("to the right", "right")}
ALONG = {-1: ("up", "upwards"), 1: ("down", "downwards")}
VERBS = ("", "move", "move it", "move the point", "go")
REPEATS: dict[float, tuple[str, ...]] = {
    2.0: ("now twice as much", "twice as much", "double that"),
    1.0: ("the same again", "once more", "do that again"),
    0.5: ("now half as much", "half of that"),
    -0.5: ("too far, go back half", "half way back"),
    -1.0: ("undo that", "go back to where it was", "no, the other way", "wrong direction"),
}
"""How much of the last move, and the words for it"""
MOST_CENTIMETRES = 40
WILLING = 0.35
"""How much of what the best words would gain an operator may leave undone by choosing others"""


@dataclass(frozen=True)
class Saying:
    """A correction, and the move that it asks for [px]."""

    text: str
    du: float
    dv: float

    def leaves(self, error: Pixel) -> float:
        """Return how far the point would be from the wanted one [px]."""
        return hypot(error[0] - self.du, error[1] - self.dv)


def choose_words(sight: Sight, last: Pixel | None, rng: np.random.Generator) -> Saying | None:
    """Return a correction that brings the shown point nearer to the wanted one.

    Not always the best one: people are content with words that do most of it.

    Args:
        sight: What the operator sees.
        last: The move of the last correction as it was seen (du, dv) [px]; None before the first.
        rng: Chooses among what fits.

    Returns:
        None where the point is nearer than the smallest step.
    """
    error = sight.error
    distance = hypot(*error)
    sayings = list(_sayings(sight, last, rng))
    best = min(saying.leaves(error) for saying in sayings)
    if best >= distance:
        return None
    limit = best + WILLING * (distance - best)
    willing = [saying for saying in sayings if saying.leaves(error) <= limit]
    return willing[int(rng.integers(len(willing)))]


def _sayings(sight: Sight, last: Pixel | None, rng: np.random.Generator) -> Iterator[Saying]:
    """Yield everything that could be said, each in words that `rng` draws."""
    yield from _along_one_axis(sight, rng)
    yield from _along_both_axes(sight, rng)
    if last is not None:
        for factor, words in REPEATS.items():
            yield Saying(_pick(rng, words), factor * last[0], factor * last[1])


def _along_one_axis(sight: Sight, rng: np.random.Generator) -> Iterator[Saying]:
    for axis in (0, 1):
        sign, to = _way(sight.error, axis, rng)
        for pixels, words in SIZES.items():
            yield _saying(rng, f"{_pick(rng, words)} {to}", axis, sign * pixels)
        number = _centimetres(sight, axis)
        if 1 <= number <= MOST_CENTIMETRES:
            move = sign * number * sight.pixels_per_cm
            yield _saying(rng, f"{number} cm {to}", axis, move)


def _along_both_axes(sight: Sight, rng: np.random.Generator) -> Iterator[Saying]:
    (across, to_across), (along, to_along) = (_way(sight.error, axis, rng) for axis in (0, 1))
    for pixels, words in SIZES.items():
        text = f"{_pick(rng, words)} {to_along} and {to_across}"
        yield Saying(_with_verb(rng, text), across * pixels, along * pixels)
    numbers = tuple(_centimetres(sight, axis) for axis in (0, 1))
    if all(1 <= number <= MOST_CENTIMETRES for number in numbers):
        text = f"{numbers[0]} cm {to_across} and {numbers[1]} cm {to_along}"
        du, dv = (number * sight.pixels_per_cm for number in numbers)
        yield Saying(_with_verb(rng, text), across * du, along * dv)


def _saying(rng: np.random.Generator, text: str, axis: int, move: float) -> Saying:
    du, dv = (move, 0.0) if axis == 0 else (0.0, move)
    return Saying(_with_verb(rng, text), du, dv)


def _way(error: Pixel, axis: int, rng: np.random.Generator) -> tuple[int, str]:
    """Return the sign of a part of the error and the words for it."""
    sign = 1 if error[axis] >= 0.0 else -1
    return sign, _pick(rng, (ACROSS if axis == 0 else ALONG)[sign])


def _centimetres(sight: Sight, axis: int) -> int:
    return round(abs(sight.error[axis]) / sight.pixels_per_cm)


def _with_verb(rng: np.random.Generator, text: str) -> str:
    return " ".join(f"{_pick(rng, VERBS)} {text}".split())


def _pick(rng: np.random.Generator, words: tuple[str, ...]) -> str:
    return words[int(rng.integers(len(words)))]
