"""Which of several things of one name: how they are told apart, and what words choose one.

Left and right, upper and lower are as seen in the picture; nearer is lower, farther is higher. No
model is asked: the words are few, and a wrong guess would be worse than a question.
"""

from collections.abc import Callable, Collection, Sequence

from w2c.messages import Box
from w2c_dialogue.utterance import fold

Rank = Callable[[Box], float]
"""The thing with the least is meant"""


def _u(box: Box) -> float:
    return box.left + box.right


def _v(box: Box) -> float:
    return box.top + box.bottom


def _area(box: Box) -> float:
    return (box.right - box.left) * (box.bottom - box.top)


def _from_right(box: Box) -> float:
    return -_u(box)


def _from_below(box: Box) -> float:
    return -_v(box)


def _from_largest(box: Box) -> float:
    return -_area(box)


SELECTIVE: dict[str, Rank] = {
    **dict.fromkeys(("left", "leftmost", "lefthand", "left-hand"), _u),
    **dict.fromkeys(("right", "rightmost", "righthand", "right-hand"), _from_right),
    **dict.fromkeys(("upper", "uppermost", "farther", "farthest", "further", "furthest"), _v),
    **dict.fromkeys(("lower", "lowermost", "nearer", "nearest", "closer", "closest"), _from_below),
    **dict.fromkeys(("big", "bigger", "biggest", "large", "larger", "largest"), _from_largest),
    **dict.fromkeys(("small", "smaller", "smallest", "little"), _area),
}
"""Words that choose one of several things even within its name: `left mug`"""
ANSWERING: dict[str, Rank] = {
    **SELECTIVE,
    **dict.fromkeys(("top", "higher", "highest", "up", "far", "back", "rear", "behind"), _v),
    **dict.fromkeys(("bottom", "lowest", "down", "near", "close", "front"), _from_below),
}
"""Words that choose one in an answer. Within a name they may say more: `top shelf`"""
MIDDLE = ("middle", "center", "centre", "central")
ORDINALS = ("first", "second", "third", "fourth", "fifth")
"""Counted from the left, or as the answer says: `second from the right`"""
FILLERS = frozenset(
    {
        "a", "an", "and", "at", "choose", "from", "guess", "i", "i'd", "in", "is", "it",
        "it's", "its", "mean", "meant", "my", "no", "of", "oh", "ok", "okay", "on", "one", "ones",
        "over", "pick", "please", "side", "sorry", "take", "that", "the", "there", "this", "to",
        "um", "use", "want", "well", "with", "yes", "you", "your",
    }
)  # fmt: skip
"""Words of an answer that choose nothing: `the one on the left side, please`"""


def names(boxes: Sequence[Box]) -> tuple[str, ...]:
    """Return what each of the things may be called, in the order in which people read them.

    Each is understood by `read_answer`.
    """
    if len(boxes) > len(ORDINALS):
        return ("left", "right")
    if len(boxes) > 3:
        return tuple(f"{word} from the left" for word in ORDINALS[: len(boxes)])
    ends = ("left", "right") if _lie_across(boxes) else ("upper", "lower")
    return ends if len(boxes) == 2 else (ends[0], "middle", ends[1])


def read_answer(words: Sequence[str], phrase: str, boxes: Sequence[Box]) -> int | None:
    """Return which thing an answer chooses; None: it is no answer, or chooses none or several.

    Args:
        words: Folded words of the operator.
        phrase: What the things are called; its words may be repeated.
        boxes: The things.
    """
    said = [word.rstrip(",") for word in words]
    known = FILLERS | {fold(word).rstrip(",") for word in phrase.split()}
    for at in range(len(said) - 1):
        if said[at] in ("left", "right") and said[at + 1] == "hand" and "side" in said:
            said[at + 1] = "side"
    chosen = [word for word in said if word in ANSWERING or word in (*MIDDLE, *ORDINALS)]
    rest = [word for word in said if word not in chosen and word not in known]
    if rest or not chosen:
        return None
    ordinal = next((word for word in chosen if word in ORDINALS), None)
    if ordinal is not None:
        others = [word for word in chosen if word != ordinal]
        return _count(ordinal, others, boxes)
    return _best(chosen, ANSWERING, boxes)


def read_phrase(phrase: str, boxes: Sequence[Box]) -> int | None:
    """Return which of several things a name means: `left mug`, `mug on the right`; None: any."""
    words = [fold(word).rstrip(",") for word in phrase.split()]
    chosen = [word for word in words if word in SELECTIVE or word in MIDDLE]
    return _best(chosen, SELECTIVE, boxes) if chosen else None


def _best(words: Collection[str], ranks: dict[str, Rank], boxes: Sequence[Box]) -> int | None:
    """Return the one thing that comes first by all words together."""
    middle = [_middle(boxes) for word in words if word in MIDDLE]
    if None in middle:
        return None
    order = [0] * len(boxes)
    for word in words:
        if word in ranks:
            ranked = sorted(range(len(boxes)), key=lambda index: ranks[word](boxes[index]))
            for place, index in enumerate(ranked):
                order[index] += place
    if middle:
        return middle[0]
    least = min(order)
    return order.index(least) if order.count(least) == 1 else None


def _middle(boxes: Sequence[Box]) -> int | None:
    if len(boxes) % 2 == 0:
        return None
    along = _u if _lie_across(boxes) else _v
    return sorted(range(len(boxes)), key=lambda index: along(boxes[index]))[len(boxes) // 2]


def _count(ordinal: str, others: Sequence[str], boxes: Sequence[Box]) -> int | None:
    """Return the thing of a number, counted from the left or from another side."""
    if len(others) > 1 or any(word not in ANSWERING for word in others):
        return None
    rank = ANSWERING[others[0]] if others else _u
    place = ORDINALS.index(ordinal)
    ranked = sorted(range(len(boxes)), key=lambda index: rank(boxes[index]))
    return ranked[place] if place < len(ranked) else None


def _lie_across(boxes: Sequence[Box]) -> bool:
    """Say whether the things lie beside each other rather than one above the other."""
    u, v = [_u(box) for box in boxes], [_v(box) for box in boxes]
    return max(u) - min(u) >= max(v) - min(v)
