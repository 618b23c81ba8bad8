"""Random choices that keep a part of every list for the held-out set."""

import zlib
from collections.abc import Sequence
from typing import TypeVar

import numpy as np

from w2c_dialogue.corpus.things import names

T = TypeVar("T")

HELD_OUT_SHARE = 40
"""One of so many entries is never seen in training: enough of the names of things to tell learning
from memory, and little of how everybody talks."""
SMALLEST_SPLIT = 20
"""Shorter lists are not split: they are grammar, not vocabulary."""
FRESH_SHARE = 0.6
"""How often the held-out set takes an unseen entry where there is one."""
COMMON = frozenset(
    names("""
table, wooden, on top of, onto, grab, touch, get, please, push, i want you to, i need you to, i'd
like you to, then, stop, the other way, wrong side, undo the last move, okay, confirm, proceed,
nice, it's good, it is good, that is perfect, do that again, half of that, half as much, move your
right hand, move your left hand, place it, arm, top, other, leftmost, over there, in front of you,
on the right, counter, fence, pink, cardboard, empty, roger, there, well done, for me, twice as far,
toolbox, cone, drill, in the centre of, in the center of, absolutely, it's okay, looks fine, roger
that, a lot more, you need to, balance yourself
""")
)
"""Words without which nobody talks: always in training."""
_BLOCK = 8192


class Draw:
    """A source of choices. `held_out` prefers entries that training never sees."""

    def __init__(self, generator: np.random.Generator, *, held_out: bool) -> None:
        self._generator = generator
        self._held_out = held_out
        self._numbers: list[float] = []
        self._split: dict[int, tuple[Sequence[object], list[object], list[object]]] = {}

    def uniform(self) -> float:
        """Return a number in [0, 1). Drawn in blocks: one call of numpy a choice would dominate."""
        if not self._numbers:
            self._numbers = self._generator.random(_BLOCK).tolist()
        return self._numbers.pop()

    def chance(self, probability: float) -> bool:
        """Return True with this probability."""
        return self.uniform() < probability

    def below(self, count: int) -> int:
        """Return an integer in [0, count)."""
        return int(self.uniform() * count)

    def between(self, low: float, high: float) -> float:
        """Return a number in [low, high)."""
        return low + (high - low) * self.uniform()

    def by_share(self, entries: Sequence[tuple[float, T]], rest: T) -> T:
        """Return one of the entries, each as often as its share says; `rest` for what is left."""
        roll = self.uniform()
        for share, entry in entries:
            if roll < share:
                return entry
            roll -= share
        return rest

    def pick(self, entries: Sequence[T]) -> T:
        """Return one of the entries that this split may use."""
        if len(entries) < SMALLEST_SPLIT:
            return entries[self.below(len(entries))]
        seen, unseen = self._parts(entries)
        pool = unseen if self._held_out and unseen and self.chance(FRESH_SHARE) else seen
        return pool[self.below(len(pool))]

    def _parts(self, entries: Sequence[T]) -> tuple[list[T], list[T]]:
        """Return the entries for training and those kept from it; the same for every seed."""
        known = self._split.get(id(entries))
        if known is None or known[0] is not entries:
            unseen: list[object] = [e for e in entries if is_held_out(e)]
            seen: list[object] = [e for e in entries if not is_held_out(e)]
            known = (entries, seen, unseen)
            self._split[id(entries)] = known
        return known[1], known[2]  # type: ignore[return-value]  # the cache holds lists of any T


def is_held_out(entry: object) -> bool:
    """Say whether an entry of a long list is kept from training."""
    text = str(entry).lower()
    return text not in COMMON and zlib.crc32(text.encode()) % HELD_OUT_SHARE == 0
