"""What corrections are made of: directions, amounts, and the words around them."""

from dataclasses import dataclass

from w2c_dialogue.corpus import correction_words as words
from w2c_dialogue.corpus.asides import with_aside
from w2c_dialogue.corpus.draft import Draft
from w2c_dialogue.corpus.draw import Draw
from w2c_dialogue.corpus.measures import distance

WAYS = {"left": (-1, 0), "right": (1, 0), "up": (0, -1), "down": (0, 1)}


@dataclass(frozen=True)
class Correction:
    """A correction and the expressions of the new target."""

    draft: Draft
    x: str
    y: str
    needs_past: int = 0
    """How many earlier corrections it speaks of"""
    scene: str = ""
    """Facts about the boxes under which it is right; empty: any"""


def term(symbol: str, sign: int, size: str) -> str:
    """Return `target.u+40`, or the symbol alone where the sign is 0."""
    return symbol + {0: "", 1: "+", -1: "-"}[sign] + (size if sign else "")


def step(draw: Draw) -> tuple[str, str]:
    """Return words of a size and its pixels."""
    size, listed = draw.by_share(words.STEPS, words.STEP)
    return draw.pick(listed), size


def sized_direction(draw: Draw, way: str) -> tuple[str, str]:
    """Return words such as `a bit to the left` and the size in pixels."""
    to = draw.pick(words.TO[way])
    if draw.chance(0.25):
        said, size = distance(draw)
        return draw.pick(
            (f"{said} {to}", f"{to} {said}", f"{to} by {said}", f"by {said} {to}")
        ), size
    if draw.chance(0.05):
        number = 2 + draw.below(4)
        word = draw.pick((str(number), ("two", "three", "four", "five")[number - 2]))
        return f"{word} steps {to}", f"{number}*40"
    said, size = step(draw)
    return (f"{to} {said}" if draw.chance(0.25) else f"{said} {to}").strip(), size


def finish(
    draw: Draw,
    template: str,
    phrases: dict[str, str],
    *,
    bare: float = 0.35,
    verbs: tuple[str, ...] = words.MOVE,
) -> Draft:
    """Put a verb in front, and what people say around it."""
    draft = Draft()
    if draw.chance(0.22):
        draft.add(draw.pick(words.LEADS))
        if draw.chance(0.5):
            draft.words[-1] = draft.words[-1].rstrip(",:") + ","
    if not draw.chance(bare):
        draft.add(draw.pick(verbs))
    draft.fill(with_aside(template, draw), phrases)
    if draw.chance(0.1):
        draft.add(draw.pick(words.TAILS))
    return draft
