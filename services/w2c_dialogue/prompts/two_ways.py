"""A correction by two amounts, cut in two: `down two cm | left three cm`.

A small model follows one amount and mixes up two. Where one word of left and right, one of up and
down (or, of engineers, u and v), and one joint between them stand in the correction, closed classes
tell which amount goes which way: the model is asked for each part. All else is left to the model.
"""

from w2c_dialogue.prompts.numerals import DIGITS, UNITS, VALUES
from w2c_dialogue.utterance import Utterance

_ACROSS = frozenset({"left", "leftward", "leftwards", "right", "rightward", "rightwards"})
_ALONG = frozenset(
    {"down", "downward", "downwards", "higher", "lower", "up", "upward", "upwards"}
)  # fmt: skip
_JOINTS = frozenset({"&", "+", "also", "and", "but", "just", "n", "only", "plus", "then", "with"})
_NUMBERS = frozenset(VALUES) | {"couple", "half", "hundred", "quarter"}
_AMOUNTS = _NUMBERS | {
    "bit", "far", "fraction", "hair", "heaps", "inch", "lil", "little", "loads", "lot",
    "marginally", "notch", "slightly", "smidge", "smidgen", "somewhat", "step", "steps",
    "tad", "ton", "tons", "touch", "way", "whisker",
}  # fmt: skip
_MORE_THAN_TWO_WAYS = frozenset(
    {
        "again", "as", "back", "before", "both", "double", "each", "except", "instead", "last",
        "mean", "not", "opposite", "other", "previous", "same", "sorry", "than", "that", "too",
        "twice", "undo",
    }
)  # fmt: skip
"""They speak of earlier moves, of both amounts at once, or take something back"""
_YES = frozenset({"all", "okay", "ok", "right", "so", "that's", "yes"})
"""`right` among these alone is no direction"""


def parts(utterance: Utterance) -> tuple[Utterance, ...]:
    """Return the two parts of a correction that goes two ways; else the correction itself.

    `A bit up and left` is one: who says an amount first and no other means both ways. A number
    without a unit has that of the other part: `3 cm up, 7 left`.
    """
    words = [word.rstrip(",") for word in utterance.folded]
    across, along = _places(words, _ACROSS, _ALONG)
    by_axes = not across and not along
    if by_axes:
        across, along = _places(words, frozenset("u"), frozenset("v"))
    if len(across) != 1 or len(along) != 1 or not _MORE_THAN_TWO_WAYS.isdisjoint(words):
        return (utterance,)
    cut = _joint(utterance, *sorted((across[0], along[0])))
    if cut is None:
        return (utterance,)
    one, other = words[: cut[0]], words[cut[1] :]
    if not _has_amount(other) or _YES.issuperset(one):
        return (utterance,)
    if by_axes and not (any(map(_is_number, one)) and any(map(_is_number, other))):
        return (utterance,)  # "can u just go 20 px along v"
    first, second = _slice(utterance, 0, cut[0]), _slice(utterance, cut[1], len(words))
    return _with_unit(first, other), _with_unit(second, one)


def _places(
    words: list[str], across: frozenset[str], along: frozenset[str]
) -> tuple[list[int], list[int]]:
    """Return where words of either stand."""
    one, other = ([at for at, word in enumerate(words) if word in ways] for ways in (across, along))
    return one, other


def _joint(utterance: Utterance, first: int, last: int) -> tuple[int, int] | None:
    """Return where the first part ends and the second begins; None: at no place, or several."""
    heard = utterance.folded
    joints = [
        at
        for at in range(first + 1, last)
        if heard[at].rstrip(",") in _JOINTS
        and not (heard[at] in ("+", "plus") and heard[at - 1] in ("u", "v"))
    ]
    pauses = [at + 1 for at in range(first, last) if heard[at].endswith(",")]
    begins = min(joints + pauses, default=None)
    if begins is None:
        return None
    ends = begins
    while ends in joints:
        ends += 1
    inside = all(at < ends for at in joints) and all(at <= ends for at in pauses)
    return (begins, ends) if inside else None


def _has_amount(words: list[str]) -> bool:
    return any(word in _AMOUNTS or any(map(str.isdigit, word)) for word in words)


def _with_unit(part: Utterance, other: list[str]) -> Utterance:
    """Return a part with the unit of the other, where its own number has none."""
    words = [word.rstrip(",") for word in part.folded]
    numbers = [at for at, word in enumerate(words) if word in _NUMBERS or _is_number(word)]
    units = [unit for word in other if (unit := word.lstrip("0123456789.")) in UNITS]
    if not numbers or not units or _has_unit(words):
        return part
    after = numbers[-1] + 1
    typed, folded, raw = (
        (*form[:after], units[0], *form[after:]) for form in (part.typed, part.folded, part.raw)
    )
    return Utterance(typed, folded, raw)


def _has_unit(words: list[str]) -> bool:
    """Tell whether a number has its unit, beside it or glued to it: `3cm`; or is no length."""
    glued = any(word[:1].isdigit() and not _is_number(word) for word in words)
    return glued or not (UNITS | _AMOUNTS - _NUMBERS).isdisjoint(words)


def _is_number(word: str) -> bool:
    return DIGITS.fullmatch(word) is not None


def _slice(utterance: Utterance, first: int, end: int) -> Utterance:
    return Utterance(
        utterance.typed[first:end], utterance.folded[first:end], utterance.raw[first:end]
    )
