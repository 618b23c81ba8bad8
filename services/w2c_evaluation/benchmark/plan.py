"""What each picture of a benchmark must be, so that the whole is balanced and not easy."""

from dataclasses import dataclass
from typing import Literal

from w2c_evaluation.benchmark.record import Look, Position


@dataclass(frozen=True)
class Slot:
    """What one picture and its prompt shall be."""

    number: int
    position: Position
    look: Look
    limb: Literal["hand", "foot"]
    pair: bool
    """The prompt is about one of two of a kind"""
    plain: bool
    """The usual name may be said; else the prompt avoids it"""


def plan(count: int) -> list[Slot]:
    """Return the slots of a benchmark of `count` pictures.

    Half are absolute, a third are outdoors, one in eight is for a foot, two in five are about one
    of two of a kind, and two in three avoid the usual name; each share holds for both halves.
    """
    return [_slot(number) for number in range(count)]


def _slot(number: int) -> Slot:
    half, which = number // 2, number % 2
    return Slot(
        number=number,
        position="absolute" if which == 0 else "relative",
        look="outdoor" if (half + which) % 3 == 1 else "indoor",
        limb="foot" if half % 8 == 3 else "hand",
        pair=half % 5 in (0, 2),
        plain=half % 3 == 1,
    )
