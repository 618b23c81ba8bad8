"""Corrections that an operator could say of the dot that is shown, and what is expected of them.

Nobody tells an operator how far "a bit" is. A person begins with an idea, in sizes of the ring,
and learns from what the dot does (`Beliefs`).
"""

from collections.abc import Iterator
from math import exp, hypot

import numpy as np

from w2c_evaluation.corrections.eye import RING_PX, Pixel
from w2c_evaluation.corrections.instructing import (
    CORNER_SHARES,
    EDGE_SHARES,
    Speaking,
    corner_of,
    divisible,
    edge_of,
)
from w2c_evaluation.corrections.saying import Saying, sentence
from w2c_evaluation.corrections.voice import Texts

AMOUNTS = {
    "tiny": 0.5 * RING_PX,
    "small": 1.2 * RING_PX,
    "plain": 2.5 * RING_PX,
    "large": 6 * RING_PX,
}
"""What amounts are to people before they have seen one [px]; plain: no amount was said"""
SAID_AMOUNTS = ("tiny", "small", "large")
OPERATORS_DIFFER = 0.3
"""Standard deviation of the logarithm of all these sizes"""
AMOUNTS_DIFFER = 0.15
"""The same of each amount beside the others"""
TRUST = 0.5
"""How much of what was seen goes into a belief"""
LARGEST_LESSON = 4.0
OF_LAST = {
    "double": 2.0,
    "same": 1.0,
    "half": 0.5,
    "too_far": -0.5,
    "back": -1.0,
    "wrong_way": -2.0,
}
"""Words that speak of the last move -> how much of it is expected"""


class Beliefs:
    """How far one operator thinks that words go: factors on what they are said to be."""

    def __init__(self, rng: np.random.Generator) -> None:
        mine = exp(rng.normal(0.0, OPERATORS_DIFFER))
        self._factors = {name: mine * exp(rng.normal(0.0, AMOUNTS_DIFFER)) for name in AMOUNTS}
        self._factors["length"] = 1.0

    def pixels(self, amount: str) -> float:
        """Return how far words of an amount go [px]."""
        return AMOUNTS[amount] * self._factors[amount]

    def factor(self, belief: str) -> float:
        """Return the factor itself."""
        return self._factors[belief]

    def learn(self, belief: str, expected: float, seen: float) -> None:
        """Take in that words went as far as was seen, instead of as expected [px]."""
        ratio = min(max(seen / max(expected, 1.0), 1.0 / LARGEST_LESSON), LARGEST_LESSON)
        self._factors[belief] *= ratio**TRUST


def corrections(
    speaking: Speaking, beliefs: Beliefs, dot: Pixel, last: Pixel | None
) -> Iterator[Saying]:
    """Yield a correction of each meaning, in words that are drawn.

    Args:
        speaking: Who speaks, about what.
        beliefs: How far words go.
        dot: That is shown.
        last: How it moved by the last correction (du, dv) [px]; None: by none.
    """
    saying = _Moving(speaking, beliefs, dot)
    yield from saying.along_one_axis()
    yield from saying.along_both_axes()
    if last is not None:
        for kind, share in OF_LAST.items():
            move = share * last[0], share * last[1]
            yield saying.said(kind, kind, move, getattr(speaking.voice.corrections, kind))
    yield from saying.by_things()


class _Moving:
    """Corrections in one look."""

    def __init__(self, speaking: Speaking, beliefs: Beliefs, dot: Pixel) -> None:
        self._speaking = speaking
        self._beliefs = beliefs
        self._dot = dot
        self._texts = speaking.voice.corrections
        # Who looks once estimates once.
        self._error = speaking.eye.offset(dot, speaking.look.ring)

    def along_one_axis(self) -> Iterator[Saying]:
        """Yield moves across or down."""
        texts, pick = self._texts, self._speaking.chooser.pick
        words, scale = self._speaking.voice.words, self._speaking.look.pixels_per_cm
        for axis in (0, 1):
            sign, to = self._way(axis)
            for amount in SAID_AMOUNTS:
                yield self.said(
                    "amount",
                    f"amount {amount} {axis} {sign}",
                    _along(axis, sign * self._beliefs.pixels(amount)),
                    texts.amount,
                    belief=amount,
                    amount=pick(getattr(words, amount)),
                    to=to,
                )
            plain = _along(axis, sign * self._beliefs.pixels("plain"))
            meaning = f"plain {axis} {sign}"
            yield self.said("plain", meaning, plain, texts.plain, belief="plain", to=to)
            for length, pixels in self._speaking.lengths(abs(self._error[axis]), scale):
                yield self.said(
                    "length",
                    f"length {length} {axis} {sign}",
                    _along(axis, sign * pixels * self._beliefs.factor("length")),
                    texts.length,
                    belief="length",
                    length=length,
                    to=to,
                )

    def along_both_axes(self) -> Iterator[Saying]:
        """Yield compound moves; the larger part comes first."""
        first = 0 if abs(self._error[0]) >= abs(self._error[1]) else 1
        (sign, to), (sign2, to2) = self._way(first), self._way(1 - first)
        signs = f"{first} {sign} {sign2}"
        texts, pick = self._texts, self._speaking.chooser.pick
        words = self._speaking.voice.words
        for amount in SAID_AMOUNTS:
            for amount2 in SAID_AMOUNTS:
                pixels = self._beliefs.pixels(amount), self._beliefs.pixels(amount2)
                yield self.said(
                    "both",
                    f"both {amount} {amount2} {signs}",
                    _compound(first, sign * pixels[0], sign2 * pixels[1]),
                    texts.both,
                    belief=amount if amount == amount2 else "",
                    amount=pick(getattr(words, amount)),
                    to=to,
                    amount2=pick(getattr(words, amount2)),
                    to2=to2,
                )
        plain = self._beliefs.pixels("plain")
        yield self.said(
            "plain_both",
            f"plain_both {signs}",
            _compound(first, sign * plain, sign2 * plain),
            texts.plain_both,
            belief="plain",
            to=to,
            to2=to2,
        )

    def by_things(self) -> Iterator[Saying]:
        """Yield moves that things in the picture say."""
        speaking, texts, words = self._speaking, self._texts, self._speaking.voice.words
        for thing in speaking.nearest():
            name = speaking.name(thing)
            if name is None or thing.furniture:
                continue
            middle = thing.centre
            yield self._place("onto", name, middle, texts.onto)
            yield self._place("level", name, (self._dot[0], middle[1]), texts.level)
            half = 0.5 * (self._dot[0] + middle[0]), 0.5 * (self._dot[1] + middle[1])
            yield self._place("halfway", name, half, texts.halfway)
            yield self._towards(name, middle)
            if not divisible(thing):
                continue
            for side in EDGE_SHARES:
                text = speaking.chooser.pick(words.sides[side])
                place = edge_of(thing, side)
                yield self._place("onto_side", name, place, texts.onto_side, side, side=text)
            for corner in CORNER_SHARES:
                text = speaking.chooser.pick(words.corners[corner])
                place = corner_of(thing, corner)
                yield self._place(
                    "onto_corner", name, place, texts.onto_corner, corner, corner=text
                )

    def said(
        self, kind: str, meaning: str, move: Pixel, texts: Texts, *, belief: str = "", **words: str
    ) -> Saying:
        """Return a correction that is expected to move the dot so [px]."""
        return Saying(
            text=sentence(self._speaking.chooser.pick(texts), **words),
            kind=kind,
            meaning=meaning,
            lands=(self._dot[0] + move[0], self._dot[1] + move[1]),
            leaves=hypot(self._error[0] - move[0], self._error[1] - move[1]),
            belief=belief,
            changes=True,
        )

    def _towards(self, name: str, middle: Pixel) -> Saying:
        """Return the move nearer to a thing, by as much as where no amount is said."""
        across, down = middle[0] - self._dot[0], middle[1] - self._dot[1]
        share = min(1.0, self._beliefs.pixels("plain") / max(hypot(across, down), 1.0))
        place = self._dot[0] + share * across, self._dot[1] + share * down
        return self._place("towards", name, place, self._texts.towards)

    def _place(
        self, kind: str, name: str, place: Pixel, texts: Texts, which: str = "", **words: str
    ) -> Saying:
        return Saying(
            text=sentence(self._speaking.chooser.pick(texts), thing=name, **words),
            kind=kind,
            meaning=f"{kind} {which} {name}",
            lands=place,
            leaves=self._speaking.leaves(place),
            name=name,
            changes=True,
        )

    def _way(self, axis: int) -> tuple[int, str]:
        """Return the sign of a part of the error and the words for it."""
        words, positive = self._speaking.voice.words, self._error[axis] >= 0.0
        sides = (words.left, words.right) if axis == 0 else (words.up, words.down)
        return (1 if positive else -1), self._speaking.chooser.pick(sides[positive])


def _along(axis: int, pixels: float) -> Pixel:
    return (pixels, 0.0) if axis == 0 else (0.0, pixels)


def _compound(first: int, pixels: float, others: float) -> Pixel:
    return (pixels, others) if first == 0 else (others, pixels)
